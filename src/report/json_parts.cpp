#include "report/json_parts.h"

#include <cmath>

#include "base/number_text.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "report/quantiles.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

Json scalar(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  double value = 0.0;
  if (!parseNumber(text, value) || !std::isfinite(value)) return text;
  if (value == std::floor(value) && std::abs(value) < 1e15) return static_cast<std::int64_t>(value);
  return value;
}

}  // namespace

Json rounded(double value, double step) {
  // by division where the step is one over a whole number: 0.3, not 0.30000000000000004
  const double inverse = std::round(1.0 / step);
  return number(step < 1.0 ? std::round(value * inverse) / inverse : std::round(value / step) * step);
}

Json effectJson(const EffectSpec& effect) {
  Json object;
  object["type"] = effect.type;
  for (const auto& [key, value] : effect.keys) {
    if (!value.list) {
      object[key] = value.items.empty() ? Json("") : scalar(value.items.front());
      continue;
    }
    Json list = Json::array();
    for (const std::string& item : value.items) list.push_back(scalar(item));
    object[key] = std::move(list);
  }
  return object;
}

void setRms(Json& object, const std::string& name, double linear, double angular) {
  object[name + "_um"] = number(linear / kMicrometre);
  if (std::isfinite(angular)) object[name + "_arcsec"] = number(angular / kArcsecond);
}

Json identifiabilityJson(const Problem& problem, const Identifiability& found, const Eigen::VectorXd& x) {
  Json object;
  object["rank"] = found.rank;
  object["parameters"] = found.parameters;
  object["lost"] = Json::array();
  for (const LostDirection& l : found.lost) {
    if (!l.ofTheModel) continue;  // of the artifact alone: no parameter is concerned
    Json one;
    one["direction"] = Json::object();
    for (const auto& [unknown, component] : l.direction)
      one["direction"][displayName(problem, unknown)] = number(component);
    const Unknown& fixed = problem.unknowns()[static_cast<std::size_t>(l.fixedUnknown)];
    one["fixed_by"] =
        displayName(problem, l.fixedUnknown) + " = " + sixDigits(x[l.fixedUnknown] * fixed.toUnit);
    one["by_convention"] = l.byConvention;
    one["no_influence"] = l.noInfluence;
    one["in_words"] = l.inWords;
    one["would_show"] = l.wouldShow;
    object["lost"].push_back(std::move(one));
  }
  return object;
}

Json outliersJson(const CalibrationResult& result) {
  Json list = Json::array();
  for (const Outlier& o : result.outliers) {
    const ResidualRow& row = result.problem->rows()[static_cast<std::size_t>(o.row)];
    Json one;
    const Session& session = result.problem->session();
    const Observation& at = session.observations[static_cast<std::size_t>(row.observation)];
    one["row"] = at.row;
    one["where"] = session.rowText(at.row, at.recording);
    one["residual_um"] = row.angular ? Json(nullptr) : number(o.residual / kMicrometre);
    if (row.angular) one["residual_arcsec"] = number(o.residual / kArcsecond);
    list.push_back(std::move(one));
  }
  return list;
}

void setSessionNotes(Json& object, const Session& session, const std::vector<Doubt>& questions) {
  object["assumed"] = Json::array();
  for (const AssumedInput& a : session.assumed)
    object["assumed"].push_back(Json{{"input", "direction of travel of " + a.joint},
                                     {"joint", a.joint},
                                     {"how", a.how},
                                     {"share", number(a.share)}});
  object["set_aside"] = Json::array();
  for (const SetAside& a : session.setAside)
    object["set_aside"].push_back(
        Json{{"row", a.row > 0 ? Json(a.row) : Json(nullptr)},
             {"where", a.row > 0 ? Json(session.rowText(a.row, a.recording)) : Json(nullptr)},
             {"field", a.field},
             {"value", a.value},
             {"why", a.why}});
  object["questions"] = Json::array();
  for (const Doubt& d : questions)
    object["questions"].push_back(Json{{"question", d.question},
                                       {"before_um", number(d.before / kMicrometre)},
                                       {"after_um", number(d.after / kMicrometre)}});
}

/// A figure that is in m, or in rad where the session is angular.
void setEither(Json& object, const std::string& name, double value, bool angular) {
  setRms(object, name, angular ? kNotMeasured : value, angular ? value : kNotMeasured);
}

void setFigures(Json& object, const ResidualFigures& f, bool heldOut) {
  setRms(object, "rms", f.rms, f.rmsAngular);
  if (heldOut) setRms(object, "held_out_rms", f.heldOutRms, f.heldOutRmsAngular);
}

void setPair(Json& object, const std::string& name, double before, double after, bool angular) {
  const double unit = angular ? kArcsecond : kMicrometre;
  const Json pair = Json::array({number(before / unit), number(after / unit)});
  object[name + "_um"] = angular ? Json(nullptr) : pair;
  if (angular) object[name + "_arcsec"] = pair;
}

Json whereJson(const std::vector<WhereItFails>& where) {
  Json list = Json::array();
  for (const WhereItFails& w : where) {
    Json one;
    one["variable"] = w.variable;
    one["share"] = number(w.share);
    one["p_value"] = number(w.pValue);
    one["share_beside"] = number(w.shareBeside);
    one["p_value_beside"] = number(w.pBeside);
    list.push_back(std::move(one));
  }
  return list;
}

Json ledgerJson(const std::vector<LedgerEntry>& ledger, bool angular) {
  Json out = Json::array();
  for (const LedgerEntry& e : ledger) {
    Json one;
    one["action"] = e.action;
    one["effect"] = e.effect.type.empty() ? Json(nullptr) : effectJson(e.effect);
    one["in_words"] = e.effect.type.empty() ? "" : inWords(e.effect);
    one["time"] = e.time;
    setPair(one, "rms", e.rmsBefore, e.rmsAfter, angular);
    setPair(one, "held_out_rms", e.heldOutBefore, e.heldOutAfter, angular);
    one["calibration"] = e.calibration;
    if (!e.sessions.empty()) one["sessions"] = e.sessions;
    out.push_back(std::move(one));
  }
  return out;
}

std::string dump(const Json& object) {
  // text that is not UTF-8 (a name from a foreign file) is replaced, never thrown over
  return object.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace mm
