#include "report/json.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "design/weak_directions.h"
#include "report/found_features.h"
#include "report/json_parts.h"
#include "report/quantiles.h"
#include "report/text_parts.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

using Json = nlohmann::ordered_json;

Json geneticJson(const GeneticSummary& g, bool angular) {
  Json object;
  object["method"] = g.method;
  setEither(object, "rms", g.rms, angular);
  object["generations"] = g.generations;
  object["evaluations"] = g.evaluations;
  object["seconds"] = number(g.seconds);
  object["stop"] = g.stop;
  object["seed"] = g.seed;
  return object;
}

Json parametersJson(const CalibrationResult& result) {
  const Model& model = result.problem->model();
  Json list = Json::array();
  for (int i = 0; i < model.parameterCount(); ++i) {
    const Parameter& p = model.parameter(i);
    Json one;
    one["effect"] = effectJson(model.effects()[static_cast<std::size_t>(model.effectOf(i))]->spec());
    one["name"] = p.name;
    one["value"] = number(result.x[i] * p.toUnit);
    one["std"] = number(result.std(i) * p.toUnit);
    one["unit"] = p.unit;
    list.push_back(std::move(one));
  }
  return list;
}

Json networksJson(const CalibrationResult& result) {
  const Model& model = result.problem->model();
  Json list = Json::array();
  for (const EffectPtr& effect : model.effects()) {
    const LearnedNetwork* n = effect->network();
    if (n == nullptr) continue;
    const int axis = model.domain().findJoint(effect->spec().text("axis"));
    const bool angular = model.domain().joints[static_cast<std::size_t>(axis)].kind == JointKind::kRotary;
    Json one;
    one["effect"] = effectJson(effect->spec());
    one["active"] = n->active;
    one["network"] = n->active ? nameOf(networkFromNumbers(n->numbers)->kind()) : "none";  // what works
    one["sensors"] = n->sensors;
    one["positions"] = n->positions.size();
    setEither(one, "held_out_rms", n->heldOut, angular);
    setEither(one, "held_out_rms_ridge", n->heldOutRidge, angular);
    setEither(one, "held_out_rms_none", n->heldOutNone, angular);
    one["summary"] = n->summary;
    list.push_back(std::move(one));
  }
  return list;
}

Json artifactJson(const CalibrationResult& result) {
  Json object;
  object["balls"] = Json::array();
  Json points = Json::array();
  for (const FoundFeature& f : foundFeatures(result)) {
    Json one;
    one["name"] = f.name;
    Json position = Json::array(), std = Json::array();
    for (int k = 0; k < 3; ++k) {
      position.push_back(number(f.position[k] / kMillimetre));
      std.push_back(number(f.std[k] / kMicrometre));
    }
    one[f.ball ? "centre_mm" : "position_mm"] = std::move(position);
    one["std_um"] = std::move(std);
    if (f.ball && f.radiusStd > 0.0) {
      one["radius_mm"] = number(f.radius / kMillimetre);
      one["radius_std_um"] = number(f.radiusStd / kMicrometre);
    }
    (f.ball ? object["balls"] : points).push_back(std::move(one));
  }
  if (!points.empty()) object["points"] = std::move(points);
  return object;
}

/// How much was measured, and how well it repeats.
Json observedJson(const CalibrationResult& result) {
  const bool angular = angularOnly(result);
  Json object;
  object["observations"] = result.problem->session().observations.size();
  object["repeatability_um"] = angular ? Json(nullptr) : number(result.repeatability / kMicrometre);
  if (angular) object["repeatability_arcsec"] = number(result.repeatability / kArcsecond);
  object["repeatability_from"] = result.repeatabilityFrom;
  return object;
}

Json calibrationJson(const CalibrationResult& result, const std::vector<Doubt>& questions = {}) {
  const bool angular = angularOnly(result);
  Json object = observedJson(result);
  if (result.repeated.dof > 0.0) {
    object["repeatability_dof"] = number(result.repeated.dof);
    object["repeatability_relative_std"] = number(result.repeated.relativeStd());
  }
  object["drift"] = Json::array();
  for (const Drift& d : result.drift) {
    const int joint = result.problem->model().domain().findJoint(d.direction);
    const bool turns =
        joint >= 0 &&
        result.problem->model().domain().joints[static_cast<std::size_t>(joint)].kind == JointKind::kRotary;
    Json one{{"direction", d.direction}};
    one["std_um"] = turns ? Json(nullptr) : number(d.std / kMicrometre);
    if (turns) one["std_arcsec"] = number(d.std / kArcsecond);
    one["time_constant_s"] = number(d.timeConstant);
    object["drift"].push_back(std::move(one));
  }
  setFigures(object, result.figures, true);
  object["chi2_per_dof"] = number(result.figures.chi2PerDof);
  object["converged"] = result.converged;
  object["genetic"] = result.genetic ? geneticJson(*result.genetic, angular) : Json(nullptr);
  object["polish"] = Json::object();
  setFigures(object["polish"], result.figures, false);
  object["polish"]["iterations"] = result.iterations;
  object["parameters"] = parametersJson(result);
  if (!result.problem->model().networks().empty()) object["networks"] = networksJson(result);
  object["identifiability"] = identifiabilityJson(*result.problem, result.identifiability, result.x);
  object["weak"] = Json::array();
  for (const WeakDirection& w : weakDirections(result)) {
    Json one;
    for (const auto& [unknown, part] : w.direction)
      one["direction"][displayName(*result.problem, unknown)] = number(part);
    one["times_median"] = number(w.timesMedian);
    one["in_words"] = w.inWords;
    object["weak"].push_back(std::move(one));
  }
  object["artifact"] = artifactJson(result);
  object["outliers"] = outliersJson(result);
  setSessionNotes(object, result.problem->session(), questions);
  return object;
}

}  // namespace

std::string calibrateJson(const CalibrationResult& result, const std::vector<Doubt>& questions) {
  return dump(calibrationJson(result, questions));
}

std::string changeJson(const CalibrationResult& result, const std::vector<LedgerEntry>& ledger) {
  Json object = calibrationJson(result);
  object["ledger"] = ledgerJson(ledger, angularOnly(result));
  return dump(object);
}

std::string compareJson(const CalibrationResult& compared, const std::vector<WhereItFails>& where) {
  Json object = observedJson(compared);
  setFigures(object, compared.figures, false);
  for (const bool arc : {false, true}) {
    const SizeOfResiduals size = sizeOfResiduals(compared, arc);
    if (arc && size.count == 0) continue;
    const std::string unit = arc ? "_arcsec" : "_um";
    const double factor = arc ? 1.0 / kArcsecond : 1.0 / kMicrometre;
    object["max" + unit] = number(size.max * factor);
    Json quantiles;
    for (const auto& [percent, value] : size.quantiles)
      quantiles[std::to_string(percent)] = number(value * factor);
    object["quantiles" + unit] = std::move(quantiles);
  }
  object["chi2_per_dof"] = number(compared.figures.chi2PerDof);
  setRms(object, "held_out_rms", compared.figures.heldOutRms, compared.figures.heldOutRmsAngular);
  object["where"] = whereJson(where);
  object["artifact"] = artifactJson(compared);
  object["outliers"] = outliersJson(compared);
  return dump(object);
}

}  // namespace mm
