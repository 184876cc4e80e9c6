#include "tools/population_prior.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/error.h"
#include "base/format.h"
#include "estimation/fitter.h"
#include "estimation/folds.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"
#include "fleet/robust_numbers.h"
#include "model/model_spec.h"
#include "tools/one_line.h"

namespace mm {
namespace {

constexpr double kConflict = 1e-3;  // chance below which a machine is no sister

/// Residual of each data row (m, rad) under the fit to the other folds, of the problem linearised at x, with
/// further rows: how these change with the unknowns (rows x all unknowns), in units of their uncertainty.
Eigen::VectorXd heldOutAt(const CalibrationResult& fit, const Eigen::VectorXd& x,
                          const Eigen::MatrixXd& more) {
  const Problem& problem = *fit.problem;
  const WhitenedSystem system(problem, x, inverseOf(fit.sigma, fit.weight), fit.identifiability.fixed);
  const Eigen::Index rows = system.jacobian.rows(), columns = system.jacobian.cols();
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(rows + more.rows(), columns);
  jacobian.topRows(rows) = system.jacobian;
  for (Eigen::Index k = 0; k < columns; ++k)
    jacobian.col(k).tail(more.rows()) = more.col(system.free[static_cast<std::size_t>(k)]) * system.scale[k];
  Eigen::VectorXd residuals = Eigen::VectorXd::Zero(jacobian.rows());
  residuals.head(rows) = system.residuals;
  const ThinQr qr = thinQr(jacobian, localBlocks(problem, jacobian, system.free), true);
  return heldOutResiduals(qr.q, residuals, makeFolds(problem))
      .head(problem.rowCount())
      .cwiseProduct(fit.sigma);
}

}  // namespace

PriorOfSisters::PriorOfSisters(const std::string& folder, const std::string& except) : folder_(folder) {
  if (!folder.empty()) all_ = populationPriors(loadFleet(folder, {}), except);
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
      if (result.identifiability.fixed[static_cast<std::size_t>(i)] != 0) continue;
      used_.push_back({prior, p.toUnit});
      at_.push_back(i);
    }
  }
  mean_.resize(static_cast<Eigen::Index>(used_.size()));
  std_ = mean_;
  for (Eigen::Index i = 0; i < mean_.size(); ++i) {
    const Used& u = used_[static_cast<std::size_t>(i)];
    mean_[i] = u.sisters.mean / u.toUnit;
    std_[i] = u.sisters.std / u.toUnit;
  }
  if (!known)
    throw InputError(
        "--prior " + folder_ +
        ": the machines there have no parameter of this model; calibrate them with the same effects, or omit "
        "--prior");
}

void PriorOfSisters::judge(const CalibrationResult& result) {
  const Eigen::VectorXd away = result.x(at_) - mean_;
  Eigen::MatrixXd expected = result.covariance(at_, at_);
  expected.diagonal() += std_.cwiseAbs2();
  double least = 2.0;
  for (std::size_t i = 0; i < used_.size(); ++i) {
    const Used& u = used_[i];
    const auto row = static_cast<Eigen::Index>(i);
    const double p =
        twoSidedT(away[row] / std::sqrt(expected(row, row)), static_cast<double>(u.sisters.machines) - 1.0);
    if (p >= least) continue;
    least = p;
    worst_ = u.sisters.name + " of " + u.sisters.effect +
             format(" is %.3g ± %.2g %s here, %.3g ± %.2g %s on %zu machines of the same type (k = 2)",
                    result.x[at_[i]] * u.toUnit, 2.0 * result.std(at_[i]) * u.toUnit, u.sisters.unit.c_str(),
                    u.sisters.mean, 2.0 * u.sisters.std, u.sisters.unit.c_str(), u.sisters.machines);
  }
  if (used_.empty()) return;
  const auto count = static_cast<double>(used_.size());
  const double together = conflictOf(away.dot(solveSymmetric(expected, away)), count);
  chance_ = std::min({1.0, 2.0 * together, 2.0 * count * least});  // two ways of asking
  contradicted_ = chance_ < kConflict;
}

void PriorOfSisters::update(CalibrationResult& result) const {
  const Eigen::MatrixXd seen = result.covariance(Eigen::all, at_);
  Eigen::MatrixXd total = seen(at_, Eigen::all);
  total.diagonal() += std_.cwiseAbs2();
  const Eigen::MatrixXd gain = solveSymmetric(total, seen.transpose()).transpose();
  result.x += gain * (mean_ - result.x(at_));
  const Eigen::MatrixXd covariance = result.covariance - gain * seen.transpose();
  result.covariance = 0.5 * (covariance + covariance.transpose());
}

void PriorOfSisters::judgeAnew(const CalibrationResult& alone, CalibrationResult& joined) const {
  const Eigen::Index count = mean_.size();
  const double variance = alone.figures.chi2PerDof > 0.0 ? alone.figures.chi2PerDof : 1.0;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(count, alone.x.size());
  double priors = 0.0;
  for (Eigen::Index i = 0; i < count; ++i) {
    const int parameter = at_[static_cast<std::size_t>(i)];
    rows(i, parameter) = std::sqrt(variance) / std_[i];  // the session's rows count by their own scatter
    priors += std::pow((joined.x[parameter] - mean_[i]) / std_[i], 2);
  }
  // networks are judged by training them again, which a prior of other parameters hardly changes
  joined.heldOut = alone.heldOut + heldOutAt(alone, joined.x, rows) -
                   heldOutAt(alone, alone.x, Eigen::MatrixXd::Zero(0, alone.x.size()));
  const Problem& problem = *alone.problem;
  joined.figures.heldOutRms = rmsOf(problem, joined.heldOut, alone.weight, false);
  joined.figures.heldOutRmsAngular = rmsOf(problem, joined.heldOut, alone.weight, true);
  const double dof = alone.figures.degreesOfFreedom;
  if (!(dof > 0.0)) return;
  const Eigen::VectorXd inverse = inverseOf(alone.sigma, alone.weight);
  double grown = 0.0;
  for (Eigen::Index i = 0; i < inverse.size(); ++i)
    if (inverse[i] > 0.0)  // the others may not even have a residual
      grown += std::pow(joined.residuals[i] * inverse[i], 2) - std::pow(alone.residuals[i] * inverse[i], 2);
  joined.figures.chi2PerDof =
      (alone.figures.chi2PerDof * dof + grown + priors) / (dof + static_cast<double>(count));
}

void PriorOfSisters::tell(std::size_t fewest) const {
  if (contradicted_)
    warn(format("this machine differs from those in %s (p = %.2g): ", folder_.c_str(), chance_) + worst_ +
         "; the prior is not used");
  else
    say(
        format("note: %zu parameters have a prior from at least %zu machines in %s; the session agrees with "
               "it (p = %.2g)",
               used_.size(), fewest, folder_.c_str(), chance_));
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
  const CalibrationResult alone = fitted.result;
  Recalibration done = std::move(fitted);
  update(done.result);
  // the figures of the values that are written, not of those that the session alone has
  const std::string machine = done.calibration.machineName;
  const CalibrationResult held = compareCalibration(session, toCalibration(done.result, machine), options);
  ResidualFigures& figures = done.result.figures;
  done.result.residuals = held.residuals;
  figures.rms = held.figures.rms;
  figures.rmsAngular = held.figures.rmsAngular;
  judgeAnew(alone, done.result);
  const std::vector<LedgerEntry> ledger = done.calibration.ledger;
  done.calibration = toCalibration(done.result, machine);
  done.calibration.ledger = ledger;
  for (LedgerEntry& entry : done.calibration.ledger) {
    const bool angular = !std::isfinite(figures.rms);
    entry.rmsAfter = angular ? figures.rmsAngular : figures.rms;
    entry.heldOutAfter = angular ? figures.heldOutRmsAngular : figures.heldOutRms;
  }
  done.calibration.method += format(", prior of %zu machines", fewest);
  return done;
}

Json PriorOfSisters::json() const {
  const auto used = [](const Used& u) -> Json {
    return {{"parameter", u.sisters.name + " of " + u.sisters.effect},
            {"mean", u.sisters.mean},
            {"std", u.sisters.std},
            {"unit", u.sisters.unit},
            {"machines", u.sisters.machines}};
  };
  return {{"folder", folder_},
          {"used", !contradicted_ && !used_.empty()},
          {"contradicted", contradicted_},
          {"chance", chance_},
          {"parameters", jsonList(used_, used)}};
}

}  // namespace mm
