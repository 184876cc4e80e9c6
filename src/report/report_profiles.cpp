#include "report/report_profiles.h"

#include <algorithm>
#include <cmath>

#include "base/quantity_words.h"
#include "effects/effect_words.h"
#include "effects/formula_variables.h"
#include "effects/owned.h"
#include "estimation/linearisation.h"
#include "estimation/noise_rows.h"
#include "report/report_variables.h"

namespace mm {
namespace {

constexpr std::size_t kMeasurementsShown = 1500;

/// The curve at a place, between its points; beyond its ends what it has there.
double curveAt(const std::vector<ProfileCurve::Point>& curve, double at) {
  const auto next =
      std::lower_bound(curve.begin(), curve.end(), at, [](const auto& p, double v) { return p.at[0] < v; });
  if (next == curve.begin()) return curve.front().value;
  if (next == curve.end()) return curve.back().value;
  const auto before = next - 1;
  return before->value + (next->value - before->value) * (at - before->at[0]) / (next->at[0] - before->at[0]);
}

/// What was measured: the residual of each row that tells of the direction, above the curve.
void addMeasured(AddedProfile& p, const CalibrationResult& fitted, int variable) {
  const bool angular = p.curve.unit == "arcsec";
  const Problem& problem = *fitted.problem;
  const FormulaVariables variables(problem.model().domain());
  std::vector<int> used;
  for (int i = 0; i < problem.rowCount(); ++i) {
    const ResidualRow& row = problem.rows()[static_cast<std::size_t>(i)];
    if (row.angular == angular && problem.uses(row.observation) && fitted.weight[i] > 0.0) used.push_back(i);
  }
  Directions directions = directionsOf(linearise(problem, fitted.x), used);
  dropUnmeasured(directions);
  const auto name = std::find(directions.names.begin(), directions.names.end(), p.direction);
  if (name == directions.names.end()) return;
  const Eigen::VectorXd factors = directions.factors.col(name - directions.names.begin());
  const double largest = factors.cwiseAbs().maxCoeff();
  std::vector<std::pair<double, double>> points;
  for (std::size_t k = 0; k < used.size(); ++k) {
    const double left =
        residualAlong(fitted.residuals[used[k]], factors[static_cast<Eigen::Index>(k)], largest) /
        unitOf(angular);
    double at = 0.0;
    variables.values(problem.state(problem.rows()[static_cast<std::size_t>(used[k])].observation), {variable},
                     &at);
    if (std::isfinite(left) && std::isfinite(at)) points.emplace_back(at, curveAt(p.curve.points, at) + left);
  }
  const std::size_t shown = std::min(kMeasurementsShown, points.size());
  for (std::size_t n = 0; n < shown; ++n) {
    const auto& [at, value] = points[n * points.size() / shown];
    p.x.push_back(at);
    p.y.push_back(value);
  }
}

}  // namespace

std::vector<AddedProfile> addedProfiles(const CalibrationResult& fitted) {
  const Model& model = fitted.problem->model();
  const Domain& domain = model.domain();
  const FormulaVariables variables(domain);
  std::vector<AddedProfile> all;
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    EffectSpec spec = model.effects()[e]->spec();
    takeOwner(spec);
    if (spec.type != "profile" || spec.text("variable").empty()) continue;
    const int first = model.offset(static_cast<int>(e)), count = model.effects()[e]->parameterCount();
    AddedProfile p;
    p.curve = profileCurve(spec, domain, fitted.x.segment(first, count),
                           fitted.covariance.block(first, first, count, count));
    p.inWords = inWords(model.effects()[e]->spec());
    p.direction = spec.text("direction");
    p.variable = spec.text("variable");
    const auto& names = variables.names();
    const auto found = std::find(names.begin(), names.end(), p.variable);
    if (found == names.end() || p.curve.points.empty()) continue;
    const auto index = static_cast<int>(found - names.begin());
    p.variableUnit = variables.unit(index);
    addMeasured(p, fitted, index);
    all.push_back(std::move(p));
  }
  return all;
}

}  // namespace mm
