#include "report/verify_json.h"

#include <sstream>

#include "base/format.h"
#include "base/quantity_words.h"
#include "base/text.h"
#include "effects/effect_words.h"
#include "report/json_parts.h"

namespace mm {
namespace {

double perUnit(const Verification& v) { return 1.0 / unitOf(v.angular); }

/// `<name>_um`, or `<name>_arcsec`.
std::string inUnit(const std::string& name, const Verification& v) {
  return name + "_" + nameOfUnit(v.angular);
}

/// @param of an object that says of what it is.
Json shareJson(const Json& of, const RemainingShare& share, const Verification& v) {
  return jsonObject({of,
                     {{inUnit("size", v), share.size * perUnit(v)},
                      {"remaining", share.remaining},
                      {"k2", 2.0 * share.std},
                      {"in_words", share.inWords}}});
}

/// How the external offsets of an export are loaded; null where it has none.
Json offsetsJson(const Verification& v) {
  if (!v.offsets) return nullptr;
  static constexpr const char* kStates[] = {"loaded", "not_loaded", "wrong_sign", "loaded_twice"};
  const std::optional<AxisState>& state = v.hypothesis.offsets;
  return shareJson({{"state", state ? kStates[static_cast<std::size_t>(*state)] : "not_told"}}, *v.offsets,
                   v);
}

Json changedJson(const ChangedEffect& changed) {
  const auto parameter = [](const ChangedEffect::Parameter& p) -> Json {
    return {{"name", p.name}, {"change", p.change}, {"k2", 2.0 * p.std}, {"unit", p.unit}};
  };
  return {{"effect", effectJson(changed.effect)},
          {"parameters", jsonList(changed.parameters, parameter)},
          {"p_value", changed.pValue}};
}

std::string shareInWords(const RemainingShare& share) {
  return share.std < 0.25 ? expanded(100.0 * share.remaining, 100.0 * share.std, "%") + ", " + share.inWords
                          : share.inWords;
}

std::string shareLine(const std::string& name, const RemainingShare& share, const Verification& v) {
  return format("  %-44s %10s %-7s %s\n", name.c_str(), shortNumber(share.size * perUnit(v)).c_str(),
                nameOfUnit(v.angular).c_str(), shareInWords(share).c_str());
}

}  // namespace

std::string verifyJson(const Verification& v) {
  const double unit = perUnit(v);
  const bool exported = !v.target.empty();
  const auto axis = [&](const RemainingOfAxis& a) { return shareJson({{"axis", a.axis}}, a, v); };
  const auto crossed = [](const CrossedShare& c) -> Json {
    return {{"of", c.of}, {"on", c.on}, {"share", c.share}, {"k2", 2.0 * c.std}};
  };
  const auto effect = [&](const RemainingOfEffect& e) {
    return shareJson({{"effect", effectJson(e.effect)}, {"not_carried", e.notCarried}}, e, v);
  };
  const auto rival = [](const VerifyRival& r) -> Json { return {{"in_words", r.inWords}, {"odds", r.odds}}; };
  const auto outlier = [&](const Outlier& o) -> Json {
    return {{"row", o.row}, {inUnit("residual", v), o.residual * unit}};
  };
  return jsonText(
      jsonObject({{{"verdict", nameOf(v.verdict)}},
                  underUnit(v.angular, "rms", {v.before.rms * unit, v.after.rms * unit}),
                  {{"in_words", v.inWords},
                   {inUnit("k2", v), {2.0 * v.before.std * unit, 2.0 * v.after.std * unit}},
                   {"finding", v.finding},
                   {"drifted", v.drifted},
                   {"loaded", v.loaded},
                   {"export", orNull(exported, v.target)},
                   {inUnit("not_carried", v), orNull(exported, v.notCarried * unit)},
                   {inUnit("unforeseen", v), v.unforeseen * unit},
                   {inUnit("calibrated", v), orNull(v.calibratedRms > 0.0, v.calibratedRms * unit)},
                   {"more_left_p_value", v.moreLeftPValue},
                   {"points", v.observations},
                   {inUnit("noise", v), v.noise * unit},
                   {"axes", jsonList(v.axes, axis)},
                   {"external_offsets", offsetsJson(v)},
                   {"crossed", jsonList(v.crossed, crossed)},
                   {"effects", jsonList(v.effects, effect)},
                   {"changed", jsonList(v.changed, changedJson)},
                   {"unexplained_p_value", v.unexplainedPValue},
                   {"not_excluded", jsonList(v.rivals, rival)},
                   {"outliers", jsonList(v.outliers, outlier)}}}));
}

std::string axesText(const Verification& v) {
  std::vector<std::string> axes;
  for (const RemainingOfAxis& axis : v.axes)
    axes.push_back(axis.axis + " (" + shortNumber(axis.size * perUnit(v)) + " " + nameOfUnit(v.angular) +
                   " uncorrected): " + shareInWords(axis));
  return axes.empty() ? "" : "remains of " + joined(axes, "; of ");
}

std::string verifyText(const Verification& v) {
  std::ostringstream out;
  out << v.inWords << "\n\n"
      << "  result at the fresh points                   uncorrected        remains (k = 2)\n";
  for (const RemainingOfAxis& axis : v.axes) out << shareLine("axis " + axis.axis, axis, v);
  if (v.offsets) out << shareLine("external offsets", *v.offsets, v);
  for (const RemainingOfEffect& effect : v.effects) out << shareLine(inWords(effect.effect), effect, v);
  for (const CrossedShare& c : v.crossed)
    out << "  of the correction of " << c.of << ", " << expanded(100.0 * c.share, 100.0 * c.std, "%")
        << " appear on " << c.on << "\n";
  for (const ChangedEffect& c : v.changed)
    for (const ChangedEffect::Parameter& p : c.parameters)
      out << "  changed: " << inWords(c.effect) << ", " << p.name << " " << (p.change >= 0.0 ? "+" : "")
          << expanded(p.change, p.std, p.unit) << "\n";
  for (const VerifyRival& rival : v.rivals)
    out << "  not excluded: " << rival.inWords << format(" (odds %.2g to 1)\n", rival.odds);
  if (!v.outliers.empty()) out << "  " << v.outliers.size() << " outliers were left out\n";
  return out.str();
}

}  // namespace mm
