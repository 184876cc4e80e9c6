#include "report/json.h"

#include "base/quantity_words.h"
#include "base/units.h"
#include "design/weak_directions.h"
#include "report/found_features.h"
#include "report/json_parts.h"
#include "report/symbols_of.h"
#include "report/text_parts.h"
#include "thermal/thermal_network.h"

namespace mm {
namespace {

Json geneticJson(const GeneticSummary& g, bool angular) {
  return jsonObject({{{"method", g.method}},
                     figureOf(angular, "rms", g.rms),
                     {{"generations", g.generations},
                      {"evaluations", g.evaluations},
                      {"seconds", g.seconds},
                      {"stop", g.stop},
                      {"seed", g.seed}}});
}

Json parametersJson(const CalibrationResult& result) {
  const Model& model = result.problem->model();
  const ErrorSymbols symbols = symbolsOf(result);
  Json list = Json::array();
  for (int i = 0; i < model.parameterCount(); ++i) {
    const Parameter& p = model.parameter(i);
    const EffectPtr& effect = model.effects()[static_cast<std::size_t>(model.effectOf(i))];
    list.push_back(
        jsonObject({{{"effect", effectJson(effect->spec())}},
                    symbolJson(effect->spec(), symbols),
                    parameterJson(p.name, result.x[i] * p.toUnit, result.std(i) * p.toUnit, p.unit)}));
  }
  return list;
}

Json networksJson(const Model& model) {
  Json list = Json::array();
  for (const EffectPtr& effect : model.effects()) {
    const LearnedNetwork* n = effect->network();
    if (n == nullptr) continue;
    const bool angular = isRotary(model.domain(), effect->spec().text("axis"));
    const std::string works = n->active ? nameOf(networkFromNumbers(n->numbers)->kind()) : "none";
    list.push_back(jsonObject({{{"effect", effectJson(effect->spec())},
                                {"active", n->active},
                                {"network", works},
                                {"sensors", n->sensors},
                                {"positions", n->positions.size()}},
                               figureOf(angular, "held_out_rms", n->heldOut),
                               figureOf(angular, "held_out_rms_ridge", n->heldOutRidge),
                               figureOf(angular, "held_out_rms_none", n->heldOutNone),
                               {{"summary", n->summary}}}));
  }
  return list;
}

Json artifactJson(const CalibrationResult& result) {
  Json balls = Json::array(), points = Json::array();
  for (const FoundFeature& f : foundFeatures(result)) {
    const Eigen::Vector3d at = f.position / kMillimetre, std = f.std / kMicrometre;
    const bool found = f.ball && f.radiusStd > 0.0;
    (f.ball ? balls : points)
        .push_back(jsonObject(
            {{{"name", f.name}, {f.ball ? "centre_mm" : "position_mm", at}, {"std_um", std}},
             found ? Json{{"radius_mm", f.radius / kMillimetre}, {"radius_std_um", f.radiusStd / kMicrometre}}
                   : Json()}));
  }
  return jsonObject({{{"balls", balls}}, entryIf(!points.empty(), "points", points)});
}

/// How much was measured, and how well it repeats.
Json observedJson(const CalibrationResult& result) {
  const bool angular = angularOnly(result);
  return jsonObject({{{"observations", result.problem->session().observations.size()}},
                     underUnit(angular, "repeatability", result.repeatability / unitOf(angular)),
                     {{"repeatability_from", result.repeatabilityFrom}}});
}

Json calibrationJson(const CalibrationResult& result, const std::vector<Doubt>& questions = {}) {
  const Problem& problem = *result.problem;
  const Model& model = problem.model();
  const auto drift = [&](const Drift& d) {
    const bool turns = isRotary(model.domain(), d.direction);
    return jsonObject({{{"direction", d.direction}},
                       underUnit(turns, "std", d.std / unitOf(turns)),
                       {{"time_constant_s", d.timeConstant}}});
  };
  const auto weak = [&](const WeakDirection& w) -> Json {
    return {{"direction", directionJson(problem, w.direction)},
            {"times_median", w.timesMedian},
            {"in_words", w.inWords}};
  };
  return jsonObject(
      {observedJson(result),
       result.repeated.dof > 0.0 ? Json{{"repeatability_dof", result.repeated.dof},
                                        {"repeatability_relative_std", result.repeated.relativeStd()}}
                                 : Json(),
       {{"drift", jsonList(result.drift, drift)}},
       figuresJson(result.figures, true),
       {{"chi2_per_dof", result.figures.chi2PerDof},
        {"converged", result.converged},
        {"genetic", result.genetic ? geneticJson(*result.genetic, angularOnly(result)) : Json()},
        {"polish", jsonObject({figuresJson(result.figures, false), {{"iterations", result.iterations}}})},
        {"parameters", parametersJson(result)}},
       entryIf(!model.networks().empty(), "networks", networksJson(model)),
       {{"identifiability", identifiabilityJson(problem, result.identifiability, result.x)},
        {"weak", jsonList(weakDirections(result), weak)},
        {"artifact", artifactJson(result)},
        {"outliers", outliersJson(result)}},
       sessionNotes(problem.session(), questions)});
}

/// The largest and the quantiles of those residuals that are lengths, or angles.
Json sizesJson(const CalibrationResult& compared, bool arc) {
  const SizeOfResiduals size = sizeOfResiduals(compared, arc);
  if (arc && size.count == 0) return nullptr;
  const std::string unit = "_" + nameOfUnit(arc);
  const double factor = 1.0 / unitOf(arc);
  Json quantiles;
  for (const auto& [percent, value] : size.quantiles) quantiles[std::to_string(percent)] = value * factor;
  return {{"max" + unit, size.max * factor}, {"quantiles" + unit, quantiles}};
}

}  // namespace

std::string calibrateJson(const CalibrationResult& result, const std::vector<Doubt>& questions) {
  return jsonText(calibrationJson(result, questions));
}

std::string changeJson(const CalibrationResult& result, const std::vector<LedgerEntry>& ledger) {
  return jsonText(jsonObject(
      {calibrationJson(result), {{"ledger", ledgerJson(ledger, angularOnly(result), symbolsOf(result))}}}));
}

std::string compareJson(const CalibrationResult& compared, const std::vector<WhereItFails>& where) {
  const ResidualFigures& f = compared.figures;
  return jsonText(jsonObject({observedJson(compared),
                              figuresJson(f, false),
                              sizesJson(compared, false),
                              sizesJson(compared, true),
                              {{"chi2_per_dof", f.chi2PerDof}},
                              figureJson("held_out_rms", f.heldOutRms, f.heldOutRmsAngular),
                              {{"where", whereJson(where)},
                               {"artifact", artifactJson(compared)},
                               {"outliers", outliersJson(compared)}}}));
}

}  // namespace mm
