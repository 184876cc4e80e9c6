#include "estimation/fitter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/tiny.h"
#include "estimation/refine.h"
#include "estimation/robust.h"

namespace mm {
namespace {

constexpr int kRounds = 8;  // of noise and outliers in turn: they settle in two or three
constexpr int kPasses = 3;  // with Huber's weights: each halves what is left of the bend
// Huber's weights start where 13 % of normal noise lies beyond (k = 1.5), and are asked for where a residual
// is 8 times the bulk, which no normal noise is.
constexpr double kHuber = 1.5, kGross = 8.0;
constexpr double kSameNoise = 1e-3;   // relative change that no longer moves a fit
constexpr double kFewestLeft = 0.05;  // share of the rows: a fit with hardly more rows than unknowns

Eigen::VectorXd sigmaOf(const FitTask& task, const Noise& noise) {
  return task.problem.sigmas(noise.linear, noise.angular);
}

}  // namespace

bool has(const Problem& problem, bool angular) {
  return std::any_of(problem.rows().begin(), problem.rows().end(),
                     [&](const ResidualRow& r) { return r.angular == angular; });
}

double rmsOf(const Problem& problem, const Eigen::VectorXd& r, const Eigen::VectorXd& weight, bool angular,
             int* count, bool onlyUnstated) {
  double sum = 0.0;
  int n = 0;
  for (int i = 0; i < r.size(); ++i) {
    const ResidualRow& row = problem.rows()[i];
    if (weight[i] == 0.0 || row.angular != angular || (onlyUnstated && row.statedSigma > 0.0)) continue;
    sum += r[i] * r[i];
    ++n;
  }
  if (count != nullptr) *count = n;
  return n > 0 ? std::sqrt(sum / n) : kNotMeasured;
}

Eigen::VectorXd usableWeight(const Problem& problem) {
  Eigen::VectorXd w(problem.rowCount());
  for (int i = 0; i < problem.rowCount(); ++i) w[i] = problem.uses(problem.rows()[i].observation) ? 1.0 : 0.0;
  return w;
}

Eigen::VectorXd inverseOf(const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight) {
  return weight.cwiseSqrt().cwiseQuotient(sigma);
}

int freeCount(const std::vector<char>& fixed) {
  return static_cast<int>(std::count(fixed.begin(), fixed.end(), 0));
}

Fit fitFrom(const FitTask& task, Eigen::VectorXd start, Noise noise) {
  Fit fit;
  fit.noise = std::move(noise);
  fit.x = std::move(start);
  fit.weight = usableWeight(task.problem);
  fit.sigma = sigmaOf(task, fit.noise);
  return fit;
}

Fit refined(const FitTask& task, Fit fit) {
  const CalibrateOptions& options = task.options;
  const RefineProgress progress = [&](int iteration, double) {
    if (options.progress) options.progress("refine", 1.0 - 1.0 / (1.0 + iteration));
    return !(options.cancelled && options.cancelled());
  };
  fit.sigma = sigmaOf(task, fit.noise);
  RefineResult r = refine(task.problem, fit.x, task.fixed, fit.sigma, fit.weight, progress);
  fit.x = std::move(r.x);
  fit.iterations += r.iterations;
  fit.converged = r.converged;
  fit.cancelled = r.cancelled;
  fit.stop = std::move(r.stop);
  fit.residuals = task.problem.residuals(fit.x);
  return fit;
}

Fit softened(const FitTask& task, Fit fit) {
  for (int pass = 0; pass < kPasses && !fit.cancelled; ++pass) {
    const Eigen::VectorXd w = fit.residuals.cwiseQuotient(fit.sigma);
    const double bulk = std::max(robustSigma(std::vector<double>(w.data(), w.data() + w.size())),
                                 resolutionSigma(task.problem).cwiseQuotient(fit.sigma).maxCoeff());
    if (!(bulk > 0.0) || w.cwiseAbs().maxCoeff() < kGross * bulk) break;
    fit.weight = usableWeight(task.problem);
    for (int i = 0; i < w.size(); ++i)
      fit.weight[i] *= std::min(1.0, kHuber * bulk / std::max(std::abs(w[i]), kTiny));
    fit = refined(task, std::move(fit));
  }
  return fit;
}

/// Whether more counts in a fit than rows of one noise, whose size changes nothing: rows of another unit or
/// of a stated deviation, and what is known beforehand.
bool isWeighedAgainstOthers(const Problem& problem) {
  const auto isStated = [](const ResidualRow& r) { return r.statedSigma > 0.0; };
  return (has(problem, true) && has(problem, false)) || problem.priorCount() > 0 ||
         std::any_of(problem.rows().begin(), problem.rows().end(), isStated);
}

Noise estimatedNoise(const FitTask& task, const Fit& fit, bool* moved) {
  *moved = false;
  Noise noise = fit.noise;
  if (!isWeighedAgainstOthers(task.problem)) return noise;
  const int total = static_cast<int>((fit.weight.array() > 0.0).count());
  const double dof =
      std::max(kFewestLeft, 1.0 - static_cast<double>(freeCount(task.fixed)) / std::max(1, total));
  const auto update = [&](bool angular, bool stated, double& value) {
    const double rms =
        rmsOf(task.problem, fit.residuals, fit.weight, angular, nullptr, true) / std::sqrt(dof);
    if (stated || !(rms > 0.0)) return;
    *moved |= std::abs(rms / value - 1.0) > kSameNoise;
    value = rms;
  };
  update(false, noise.linearStated, noise.linear);
  update(true, noise.angularStated, noise.angular);
  return noise;
}

Eigen::VectorXd weightsWithoutOutliers(const FitTask& task, const Fit& fit) {
  return usableWeight(task.problem)
      .cwiseProduct(outlierWeights(task.problem, fit.residuals, fit.sigma, freeCount(task.fixed)));
}

Fit fitted(const FitTask& task, Fit fit) {
  const bool reject = task.options.rejectOutliers;
  fit = refined(task, std::move(fit));
  if (reject && !fit.cancelled) fit = softened(task, std::move(fit));
  for (int round = 0; round < kRounds && !fit.cancelled; ++round) {
    bool noiseMoved = false;
    fit.noise = estimatedNoise(task, fit, &noiseMoved);
    fit.sigma = sigmaOf(task, fit.noise);
    const Eigen::VectorXd weight = reject ? weightsWithoutOutliers(task, fit) : usableWeight(task.problem);
    const bool same = weight == fit.weight;
    fit.weight = weight;
    if (same && !noiseMoved) break;
    fit = refined(task, std::move(fit));
  }
  if (reject && !fit.cancelled) {
    const Eigen::VectorXd back =
        reinstated(task.problem, fit.x, fit.residuals, fit.sigma, fit.weight, task.fixed);
    if (back != fit.weight) {
      fit.weight = back;
      fit = refined(task, std::move(fit));
    }
  }
  return fit;
}

}  // namespace mm
