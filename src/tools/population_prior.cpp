#include "tools/population_prior.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>

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
    worst_ =
        u.sisters.name + " of " + u.sisters.effect +
        format(" is %.3g ± %.2g %s here, %.3g ± %.2g %s in %zu sisters", result.x[u.parameter] * u.toUnit,
               result.std(u.parameter) * u.toUnit, u.sisters.unit.c_str(), u.sisters.mean, u.sisters.std,
               u.sisters.unit.c_str(), u.sisters.machines);
  }
  if (count == 0) return;
  const double together = conflictOf(away.dot(expected.ldlt().solve(away)), static_cast<double>(count));
  chance_ = std::min({1.0, 2.0 * together, 2.0 * static_cast<double>(count) * least});  // two ways of asking
  contradicted_ = chance_ < kConflict;
}

void PriorOfSisters::update(CalibrationResult& result) const {
  const auto count = static_cast<Eigen::Index>(used_.size());
  const Eigen::Index all = result.covariance.rows();
  Eigen::MatrixXd seen(all, count), total(count, count);
  Eigen::VectorXd away(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Used& u = used_[static_cast<std::size_t>(i)];
    seen.col(i) = result.covariance.col(u.parameter);
    away[i] = u.mean - result.x[u.parameter];
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    total.row(i) = seen.row(used_[static_cast<std::size_t>(i)].parameter);
    total(i, i) += std::pow(used_[static_cast<std::size_t>(i)].std, 2);
  }
  const Eigen::MatrixXd gain = total.ldlt().solve(seen.transpose()).transpose();
  result.x += gain * away;
  const Eigen::MatrixXd covariance = result.covariance - gain * seen.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
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
  Recalibration done = std::move(fitted);
  update(done.result);
  const std::vector<LedgerEntry> ledger = done.calibration.ledger;
  done.calibration = toCalibration(done.result, done.calibration.machineName);
  // the figures of the values that are written, not of those that the session alone has
  const CalibrationResult held = compareCalibration(session, done.calibration, options);
  done.result.residuals = held.residuals;
  done.result.figures.rms = held.figures.rms;
  done.result.figures.rmsAngular = held.figures.rmsAngular;
  done.calibration.rms = held.figures.rms;
  done.calibration.rmsAngular = held.figures.rmsAngular;
  done.calibration.ledger = ledger;
  for (LedgerEntry& entry : done.calibration.ledger)
    entry.rmsAfter = std::isfinite(held.figures.rms) ? held.figures.rms : held.figures.rmsAngular;
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
