#include "tools/population_prior.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

#include "base/dense.h"
#include "base/error.h"
#include "base/format.h"
#include "fleet/robust_numbers.h"
#include "model/model_spec.h"
#include "tools/one_line.h"

namespace mm {
namespace {

constexpr double kConflict = 1e-3;  // chance below which a machine is no sister

}  // namespace

PriorOfSisters::PriorOfSisters(const std::string& folder, const std::string& except) : folder_(folder) {
  if (!folder.empty()) all_ = populationPriors(folder, except);
}

void PriorOfSisters::match(const CalibrationResult& result) {
  const Model& model = result.problem->model();
  bool known = false;
  for (int i = 0; i < model.parameterCount(); ++i) {
    const Effect& effect = *model.effects()[static_cast<std::size_t>(model.effectOf(i))];
    const Parameter& p = model.parameter(i);
    for (const PopulationPrior& prior : all_) {
      if (prior.name != p.name || prior.unit != p.unit ||
          !sameEffect(parseEffectSpec(prior.effect, folder_), effect.spec(), model.domain()))
        continue;
      known = true;
      if (result.identifiability.fixed[static_cast<std::size_t>(i)] == 0)
        used_.push_back({prior, i, prior.mean / p.toUnit, prior.std / p.toUnit, p.toUnit});
    }
  }
  if (!known)
    throw InputError(
        "--prior " + folder_ +
        ": the sisters have no parameter of this model; calibrate them with the same effects, or leave "
        "--prior out");
}

void PriorOfSisters::judge(const CalibrationResult& result) {
  const auto count = static_cast<Eigen::Index>(used_.size());
  Eigen::VectorXd away(count);
  Eigen::MatrixXd expected(count, count);
  double least = 2.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Used& u = used_[static_cast<std::size_t>(i)];
    away[i] = result.x[u.parameter] - u.mean;
    for (Eigen::Index j = 0; j < count; ++j)
      expected(i, j) = result.covariance(u.parameter, used_[static_cast<std::size_t>(j)].parameter);
    expected(i, i) += u.std * u.std;
    const double p =
        twoSidedT(away[i] / std::sqrt(expected(i, i)), static_cast<double>(u.sisters.machines) - 1.0);
    if (p >= least) continue;
    least = p;
    worst_ = u.sisters.name + " of " + u.sisters.effect +
             format(" is %.3g ± %.2g %s here, %.3g ± %.2g %s in %zu sisters (k = 2)",
                    result.x[u.parameter] * u.toUnit, 2.0 * result.std(u.parameter) * u.toUnit,
                    u.sisters.unit.c_str(), u.sisters.mean, 2.0 * u.sisters.std, u.sisters.unit.c_str(),
                    u.sisters.machines);
  }
  if (count == 0) return;
  const double together = conflictOf(away.dot(solveSymmetric(expected, away)), static_cast<double>(count));
  chance_ = std::min({1.0, 2.0 * together, 2.0 * static_cast<double>(count) * least});  // two ways of asking
  contradicted_ = chance_ < kConflict;
}

void PriorOfSisters::tell(std::size_t fewest) const {
  if (contradicted_)
    std::cerr << "mm: warning: "
              << oneLine(format("this machine is no sister of those in %s (chance %.2g): ", folder_.c_str(),
                                chance_) +
                         worst_ + "; the prior is not used")
              << std::endl;
  else
    std::cerr
        << "mm: note: "
        << oneLine(format(
               "%zu parameters have a prior from at least %zu sister machines in %s; the session agrees "
               "with it (chance %.2g)",
               used_.size(), fewest, folder_.c_str(), chance_))
        << std::endl;
}

Recalibration PriorOfSisters::join(Recalibration fitted, const Session& session,
                                   const CalibrateOptions& options) {
  if (!asked() || fitted.result.cancelled) return fitted;
  match(fitted.result);
  judge(fitted.result);
  std::size_t fewest = used_.empty() ? 0 : used_.front().sisters.machines;
  for (const Used& u : used_) fewest = std::min(fewest, u.sisters.machines);
  tell(fewest);
  if (contradicted_ || used_.empty()) return fitted;
  const CalibrationResult& alone = fitted.result;
  const Model& model = alone.problem->model();
  CalibrateOptions with = options;
  with.method = Method::kLeastSquares;
  // the covariance is scaled by the scatter of the session's rows, and the sisters' share shall not be
  const double scatter = alone.figures.chi2PerDof > 0.0 ? std::sqrt(alone.figures.chi2PerDof) : 1.0;
  for (const Used& u : used_)
    with.priors.push_back({model.effects()[static_cast<std::size_t>(model.effectOf(u.parameter))]->spec(),
                           model.parameter(u.parameter).name, u.mean, u.std / scatter});
  Recalibration done;
  done.result = calibrate(session, model, with, alone.x.head(model.parameterCount()));
  done.result.method = alone.method;
  done.result.genetic = alone.genetic;
  done.calibration = toCalibration(done.result, fitted.calibration.machineName);
  done.calibration.ledger = fitted.calibration.ledger;
  const ResidualFigures& figures = done.result.figures;
  for (LedgerEntry& entry : done.calibration.ledger) {
    const bool angular = !std::isfinite(figures.rms);
    entry.rmsAfter = angular ? figures.rmsAngular : figures.rms;
    entry.heldOutAfter = angular ? figures.heldOutRmsAngular : figures.heldOutRms;
  }
  done.calibration.method += format(", prior of %zu machines", fewest);
  return done;
}

nlohmann::ordered_json PriorOfSisters::json() const {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Used& u : used_)
    list.push_back({{"parameter", u.sisters.name + " of " + u.sisters.effect},
                    {"mean", u.sisters.mean},
                    {"std", u.sisters.std},
                    {"unit", u.sisters.unit},
                    {"machines", u.sisters.machines}});
  return {{"folder", folder_},
          {"used", !contradicted_ && !used_.empty()},
          {"contradicted", contradicted_},
          {"chance", chance_},
          {"parameters", list}};
}

}  // namespace mm
