#include "posterior/problem.h"

#include <cmath>

namespace mm {
namespace {

constexpr double kDriftNats = 0.7;   // wandering is common, whatever its direction and time constant
constexpr double kSmoothNats = 2.0;  // a smooth course is less so
constexpr double kAlike = 0.05;      // of a ratio or a time constant

bool near(double a, double b) { return std::abs(a - b) <= kAlike * std::max(std::abs(a), std::abs(b)); }

}  // namespace

double NoiseState::logPrior(const PosteriorProblem& problem) const {
  double sum = 0.0;
  for (const DriftTerm& t : drift)
    if (t.ratio > 0.0) sum -= (t.smooth ? kSmoothNats : kDriftNats) + std::log1p(t.ratio * t.ratio);
  for (std::size_t b = 0; b < scatter.size(); ++b)
    if (scatter[b] > 0.0 && !problem.scatter[b].fixed)
      sum -= problem.scatter[b].nats + std::log1p(scatter[b] * scatter[b]);
  return sum;
}

bool NoiseState::resembles(const NoiseState& other) const {
  if (drift.size() != other.drift.size() || scatter.size() != other.scatter.size() ||
      variance != other.variance)
    return false;
  for (std::size_t k = 0; k < drift.size(); ++k) {
    const DriftTerm &a = drift[k], &b = other.drift[k];
    if (a.direction != b.direction || a.smooth != b.smooth || !near(a.ratio, b.ratio) || !near(a.tau, b.tau))
      return false;
  }
  for (std::size_t b = 0; b < scatter.size(); ++b)
    if (!near(scatter[b], other.scatter[b])) return false;
  return true;
}

}  // namespace mm
