#include "estimation/fitter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "estimation/polish.h"
#include "estimation/robust.h"

namespace mm {

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

Fitter::Fitter(const Problem& problem, const CalibrateOptions& options, Noise noise)
    : problem_(problem), options_(options), noise(std::move(noise)), weight(usableWeight(problem)) {}

void Fitter::run(Eigen::VectorXd start, const std::vector<char>& fixed) {
  x = std::move(start);
  fit(fixed);
  if (options_.rejectOutliers && !cancelled) soften(fixed);
  for (int round = 0; round < 8 && !cancelled; ++round) {
    const bool noiseMoved = estimateNoise(fixed);
    Eigen::VectorXd next = usableWeight(problem_);
    if (options_.rejectOutliers)
      next = next.cwiseProduct(outlierWeights(
          problem_, residuals.cwiseQuotient(problem_.sigmas(noise.linear, noise.angular)), freeCount(fixed)));
    const bool same = next == weight;
    weight = next;
    if (same && !noiseMoved) break;
    fit(fixed);
  }
  if (options_.rejectOutliers && !cancelled) {
    const Eigen::VectorXd back =
        reinstated(problem_, x, residuals, problem_.sigmas(noise.linear, noise.angular), weight, fixed);
    if (back != weight) {
      weight = back;
      fit(fixed);
    }
  }
  sigma = problem_.sigmas(noise.linear, noise.angular);
}

void Fitter::fitOnce(Eigen::VectorXd start, const std::vector<char>& fixed) {
  x = std::move(start);
  fit(fixed);
  sigma = problem_.sigmas(noise.linear, noise.angular);
}

void Fitter::fit(const std::vector<char>& fixed) {
  PolishOptions polishing;
  polishing.progress = [&](int iteration, double) {
    if (options_.progress) options_.progress("polish", 1.0 - 1.0 / (1.0 + iteration));
    return !(options_.cancelled && options_.cancelled());
  };
  const PolishResult p =
      polish(problem_, x, fixed, problem_.sigmas(noise.linear, noise.angular), weight, polishing);
  x = p.x;
  iterations += p.iterations;
  converged = p.converged;
  cancelled = p.cancelled;
  stop = p.stop;
  residuals = problem_.residuals(x);
}

/// Gross outliers must not bend the fit that is to unmask them: two passes with Huber's weights.
void Fitter::soften(const std::vector<char>& fixed) {
  for (int pass = 0; pass < 3 && !cancelled; ++pass) {
    const Eigen::VectorXd w = residuals.cwiseQuotient(problem_.sigmas(noise.linear, noise.angular));
    const double bulk = robustSigma(std::vector<double>(w.data(), w.data() + w.size()));
    if (!(bulk > 0.0) || w.cwiseAbs().maxCoeff() < 8.0 * bulk) return;
    weight = usableWeight(problem_);
    for (int i = 0; i < w.size(); ++i)
      weight[i] *= std::min(1.0, 1.5 * bulk / std::max(std::abs(w[i]), 1e-300));
    fit(fixed);
  }
}

/// Rows of two kinds without stated noise are weighed by their own residuals. @return whether a weight
/// moved.
bool Fitter::estimateNoise(const std::vector<char>& fixed) {
  if (!has(problem_, true) || !has(problem_, false)) {
    return false;
  }
  const int total = static_cast<int>((weight.array() > 0.0).count());
  const double dof = std::max(0.05, 1.0 - static_cast<double>(freeCount(fixed)) / std::max(1, total));
  bool moved = false;
  const auto update = [&](bool angular, bool stated, double& value) {
    const double rms = rmsOf(problem_, residuals, weight, angular, nullptr, true) / std::sqrt(dof);
    if (stated || !(rms > 0.0)) return;
    moved |= std::abs(rms / value - 1.0) > 1e-3;
    value = rms;
  };
  update(false, noise.linearStated, noise.linear);
  update(true, noise.angularStated, noise.angular);
  return moved;
}

}  // namespace mm
