#include "report/verify_json.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "base/format.h"
#include "base/quantity_words.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "report/json_parts.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

double perUnit(const Verification& v) { return 1.0 / (v.angular ? kArcsecond : kMicrometre); }

Json shareJson(Json object, const RemainingShare& share, const Verification& v) {
  object[v.angular ? "size_arcsec" : "size_um"] = number(share.size * perUnit(v));
  object["remaining"] = number(share.remaining);
  object["k2"] = number(2.0 * share.std);
  object["in_words"] = share.inWords;
  return object;
}

/// How the external offsets of an export are loaded; null where it has none.
Json offsetsJson(const Verification& v) {
  if (!v.offsets) return nullptr;
  std::string state = "not_told";
  if (v.hypothesis.offsets) switch (*v.hypothesis.offsets) {
      case AxisState::kCorrected:
        state = "loaded";
        break;
      case AxisState::kNotCorrected:
        state = "not_loaded";
        break;
      case AxisState::kWrongSign:
        state = "wrong_sign";
        break;
      case AxisState::kTwice:
        state = "loaded_twice";
        break;
    }
  return shareJson({{"state", state}}, *v.offsets, v);
}

Json changedJson(const ChangedEffect& changed) {
  Json parameters = Json::array();
  for (const ChangedEffect::Parameter& p : changed.parameters)
    parameters.push_back(
        {{"name", p.name}, {"change", number(p.change)}, {"k2", number(2.0 * p.std)}, {"unit", p.unit}});
  return {{"effect", effectJson(changed.effect)},
          {"parameters", parameters},
          {"p_value", number(changed.pValue)}};
}

std::string shareLine(const std::string& name, const RemainingShare& share, const Verification& v) {
  return format(
      "  %-44s %10s %-7s %s\n", name.c_str(), shortNumber(share.size * perUnit(v)).c_str(),
      v.angular ? "arcsec" : "um",
      (share.std < 0.25 ? expanded(100.0 * share.remaining, 100.0 * share.std, "%") + ", " + share.inWords
                        : share.inWords)
          .c_str());
}

}  // namespace

std::string verifyJson(const Verification& v) {
  Json object;
  object["verdict"] = nameOf(v.verdict);
  const double unit = perUnit(v);
  const Json figures = {number(v.before.rms * unit), number(v.after.rms * unit)};
  object["rms_um"] = v.angular ? Json(nullptr) : figures;
  if (v.angular) object["rms_arcsec"] = figures;
  object["in_words"] = v.inWords;
  object[v.angular ? "k2_arcsec" : "k2_um"] = {number(2.0 * v.before.std * unit),
                                               number(2.0 * v.after.std * unit)};
  object["finding"] = v.finding;
  object["drifted"] = v.drifted;
  object["loaded"] = v.loaded;
  object["export"] = v.target.empty() ? Json(nullptr) : Json(v.target);
  object[v.angular ? "not_carried_arcsec" : "not_carried_um"] =
      v.target.empty() ? Json(nullptr) : number(v.notCarried * unit);
  object[v.angular ? "unforeseen_arcsec" : "unforeseen_um"] = number(v.unforeseen * unit);
  object[v.angular ? "calibrated_arcsec" : "calibrated_um"] =
      v.calibratedRms > 0.0 ? number(v.calibratedRms * unit) : Json(nullptr);
  object["more_left_p_value"] = number(v.moreLeftPValue);
  object["points"] = v.observations;
  object[v.angular ? "noise_arcsec" : "noise_um"] = number(v.noise * unit);
  object["axes"] = Json::array();
  for (const RemainingOfAxis& axis : v.axes)
    object["axes"].push_back(shareJson({{"axis", axis.axis}}, axis, v));
  object["external_offsets"] = offsetsJson(v);
  object["crossed"] = Json::array();
  for (const CrossedShare& c : v.crossed)
    object["crossed"].push_back(
        {{"of", c.of}, {"on", c.on}, {"share", number(c.share)}, {"k2", number(2.0 * c.std)}});
  object["effects"] = Json::array();
  for (const RemainingOfEffect& e : v.effects)
    object["effects"].push_back(
        shareJson({{"effect", effectJson(e.effect)}, {"not_carried", number(e.notCarried)}}, e, v));
  object["changed"] = Json::array();
  for (const ChangedEffect& c : v.changed) object["changed"].push_back(changedJson(c));
  object["unexplained_p_value"] = number(v.unexplainedPValue);
  object["not_excluded"] = Json::array();
  for (const VerifyRival& rival : v.rivals)
    object["not_excluded"].push_back({{"in_words", rival.inWords}, {"odds", number(rival.odds)}});
  object["outliers"] = Json::array();
  for (const Outlier& o : v.outliers)
    object["outliers"].push_back(
        {{"row", o.row}, {v.angular ? "residual_arcsec" : "residual_um", number(o.residual * unit)}});
  return dump(object);
}

std::string verifyText(const Verification& v) {
  std::ostringstream out;
  out << v.inWords << "\n\n"
      << "  what the fresh points say                    uncorrected        remains (k = 2)\n";
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
  if (!v.outliers.empty()) out << "  " << v.outliers.size() << " residuals stand apart and were left out\n";
  return out.str();
}

}  // namespace mm
