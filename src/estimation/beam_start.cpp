#include "estimation/beam_start.h"

#include <Eigen/Core>

#include "base/cancel_scope.h"
#include "base/dense.h"
#include "estimation/whitened.h"

namespace mm {
namespace {

constexpr double kMuchBetter = 0.25;  // of the sum of squares

/// Sum of squares after one linear step of everything but the beam; x takes the step where it helps.
double refitted(const Problem& problem, const UnitVector& beam, Eigen::VectorXd& x,
                const std::vector<char>& fixed, const Eigen::VectorXd& inverseSigma) {
  std::vector<char> held = fixed;
  for (int k = 0; k < 3; ++k) held[static_cast<std::size_t>(beam.first + k)] = 1;
  const WhitenedSystem system(problem, x, inverseSigma, held);
  double cost = system.residuals.squaredNorm();
  if (system.free.empty() || !system.jacobian.allFinite()) return cost;
  const Eigen::VectorXd step = leastSquares(system.jacobian, -system.residuals);
  Eigen::VectorXd next = x;
  for (std::size_t i = 0; i < system.free.size(); ++i)
    next[system.free[i]] += step[static_cast<Eigen::Index>(i)] * system.scale[static_cast<Eigen::Index>(i)];
  const double after = WhitenedSystem(problem, next, inverseSigma, held).residuals.squaredNorm();
  if (!(after < cost)) return cost;
  x = next;
  return after;
}

}  // namespace

void beamStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
               const Eigen::VectorXd& inverseSigma) {
  for (const UnitVector& beam : problem.unitVectors()) {
    Eigen::VectorXd own = x, best;
    double least = kMuchBetter * refitted(problem, beam, own, fixed, inverseSigma);
    for (int i = 0; i < 27; ++i) {
      if (i == 13) continue;
      CancelScope::check();
      Eigen::VectorXd trial = x;
      trial.segment<3>(beam.first) = Eigen::Vector3d(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1).normalized();
      const double cost = refitted(problem, beam, trial, fixed, inverseSigma);
      if (!(cost < least)) continue;
      least = cost;
      best = trial;
    }
    if (best.size() > 0) x = best;
  }
}

}  // namespace mm
