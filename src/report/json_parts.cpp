#include "report/json_parts.h"

#include <cmath>

#include "base/number_text.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "report/text_parts.h"

namespace mm {
namespace {

Json scalar(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  double value = 0.0;
  if (!parseNumber(text, value) || !std::isfinite(value)) return text;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return value;
}

}  // namespace

Json rounded(double value, double step) {
  if (!std::isfinite(value)) return nullptr;
  // by division where the step is one over a whole number: 0.3, not 0.30000000000000004
  const double inverse = std::round(1.0 / step);
  return step < 1.0 ? std::round(value * inverse) / inverse : std::round(value / step) * step;
}

Json effectJson(const EffectSpec& effect) {
  Json object{{"type", effect.type}};
  for (const auto& [key, value] : effect.keys)
    object[key] = value.list            ? jsonList(value.items, scalar)
                  : value.items.empty() ? Json("")
                                        : scalar(value.items.front());
  return object;
}

Json symbolJson(const EffectSpec& effect, const ErrorSymbols& symbols) {
  const std::string symbol = symbols.of(effect);
  return entryIf(!symbol.empty(), "iso230", symbol);
}

Json effectInWords(const EffectSpec& effect, const ErrorSymbols& symbols) {
  return jsonObject(
      {{{"effect", effectJson(effect)}, {"in_words", inWords(effect)}}, symbolJson(effect, symbols)});
}

Json oddsJson(double probability) {
  return {{"odds", probability}, {"odds_in_words", oddsInWords(probability)}};
}

Json parameterJson(const std::string& name, double value, double std, const std::string& unit) {
  return {{"name", name}, {"value", value}, {"std", std}, {"unit", unit}};
}

Json rangeJson(const std::string& name, const std::string& unit, const Json& lower, const Json& upper) {
  return {{"name", name}, {"unit", unit}, {"lower", lower}, {"upper", upper}};
}

Json ballJson(const std::string& name, const Eigen::Vector3d& centre, double radius) {
  return {{"name", name},
          {"centre_mm", roundedList(centre, kPlaceStep)},
          {"radius_mm", rounded(radius, kPlaceStep)}};
}

Json figureJson(const std::string& name, double linear, double angular) {
  Json object{{name + "_um", linear / kMicrometre}};
  if (std::isfinite(angular)) object[name + "_arcsec"] = angular / kArcsecond;
  return object;
}

Json figureOf(bool angular, const std::string& name, double value) {
  return figureJson(name, angular ? kNotMeasured : value, angular ? value : kNotMeasured);
}

Json underUnit(bool angular, const std::string& name, const Json& value) {
  if (!angular) return {{name + "_um", value}};
  return {{name + "_um", nullptr}, {name + "_arcsec", value}};
}

Json beforeAndAfter(bool angular, const std::string& name, double before, double after) {
  return underUnit(angular, name, {before / unitOf(angular), after / unitOf(angular)});
}

Json storedJson(const CalibrationStore::Entry& e) {
  return {{"id", e.id},
          {"created", e.created},
          {"active", e.active},
          {"candidate", e.candidate},
          {"promotions", e.promotions},
          {"machine", e.machine},
          {"effects", e.effects},
          {"rms_um", e.rms / kMicrometre},
          {"held_out_rms_um", e.heldOutRms / kMicrometre},
          {"session", e.session},
          {"damaged", e.damaged}};
}

Json figuresJson(const ResidualFigures& f, bool heldOut) {
  return jsonObject({figureJson("rms", f.rms, f.rmsAngular),
                     heldOut ? figureJson("held_out_rms", f.heldOutRms, f.heldOutRmsAngular) : Json()});
}

Json whereJson(const std::vector<WhereItFails>& where) {
  return jsonList(where, [](const WhereItFails& w) -> Json {
    return {{"variable", w.variable},
            {"share", w.share},
            {"p_value", w.pValue},
            {"share_beside", w.shareBeside},
            {"p_value_beside", w.pBeside}};
  });
}

Json identifiabilityJson(const Problem& problem, const Identifiability& found, const Eigen::VectorXd& x) {
  Json lost = Json::array();
  for (const LostDirection& l : found.lost) {
    if (!l.ofTheModel) continue;  // of the artifact alone: no parameter is concerned
    const Unknown& fixed = problem.unknowns()[static_cast<std::size_t>(l.fixedUnknown)];
    const std::string value = sixDigits(x[l.fixedUnknown] * fixed.toUnit);
    lost.push_back({{"direction", directionJson(problem, l.direction)},
                    {"fixed_by", displayName(problem, l.fixedUnknown) + " = " + value},
                    {"by_convention", l.byConvention},
                    {"no_influence", l.noInfluence},
                    {"in_words", l.inWords},
                    {"would_show", l.wouldShow}});
  }
  return {{"rank", found.rank}, {"parameters", found.parameters}, {"lost", lost}};
}

Json directionJson(const Problem& problem, const std::vector<std::pair<int, double>>& direction) {
  Json object = Json::object();
  for (const auto& [unknown, part] : direction) object[displayName(problem, unknown)] = part;
  return object;
}

Json outliersJson(const CalibrationResult& result) {
  return jsonList(result.outliers, [&](const Outlier& o) {
    const ResidualRow& row = result.problem->rows()[static_cast<std::size_t>(o.row)];
    const Session& session = result.problem->session();
    const Observation& at = session.observations[static_cast<std::size_t>(row.observation)];
    return jsonObject({{{"row", at.row}, {"where", session.rowText(at.row, at.recording)}},
                       underUnit(row.angular, "residual", o.residual / unitOf(row.angular))});
  });
}

Json sessionNotes(const Session& session, const std::vector<Doubt>& questions) {
  const auto assumed = [](const AssumedInput& a) -> Json {
    return {{"input", "direction of travel of " + a.joint},
            {"joint", a.joint},
            {"how", a.how},
            {"share", a.share}};
  };
  const auto setAside = [&](const SetAside& a) -> Json {
    const bool known = a.row > 0;
    return {{"row", orNull(known, a.row)},
            {"where", known ? Json(session.rowText(a.row, a.recording)) : Json()},
            {"field", a.field},
            {"value", a.value},
            {"why", a.why}};
  };
  const auto question = [](const Doubt& d) -> Json {
    return {
        {"question", d.question}, {"before_um", d.before / kMicrometre}, {"after_um", d.after / kMicrometre}};
  };
  return {{"assumed", jsonList(session.assumed, assumed)},
          {"set_aside", jsonList(session.setAside, setAside)},
          {"questions", jsonList(questions, question)}};
}

Json testsJson(const std::vector<StandardTest>& tests) {
  return jsonList(tests, [](const StandardTest& t) -> Json {
    return {{"test", t.test}, {"in_words", t.inWords}};
  });
}

Json ledgerJson(const std::vector<LedgerEntry>& ledger, bool angular, const ErrorSymbols& symbols) {
  return jsonList(ledger, [&](const LedgerEntry& e) {
    const bool ofEffect = !e.effect.type.empty();
    return jsonObject({{{"action", e.action},
                        {"effect", orNull(ofEffect, effectJson(e.effect))},
                        {"in_words", ofEffect ? inWords(e.effect) : ""}},
                       symbolJson(e.effect, symbols),
                       {{"time", e.time}},
                       beforeAndAfter(angular, "rms", e.rmsBefore, e.rmsAfter),
                       beforeAndAfter(angular, "held_out_rms", e.heldOutBefore, e.heldOutAfter),
                       {{"calibration", e.calibration}},
                       entryIf(!e.sessions.empty(), "sessions", e.sessions)});
  });
}

}  // namespace mm
