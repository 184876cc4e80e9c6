#include "fleet/recurrence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace mm {
namespace {

constexpr double kNever = -std::numeric_limits<double>::infinity();

/// log of the sum of two numbers given by their logarithms.
double logSum(double a, double b) {
  if (a == kNever) return b;
  const double larger = std::max(a, b), smaller = std::min(a, b);
  return larger + std::log1p(std::exp(smaller - larger));
}

/// Of `found` among `count` trials with one unknown probability: B(found + 1/2, count - found + 1/2) / pi.
double logEvidence(double found, double count) {
  constexpr double kLogPi = 1.1447298858494002;
  return std::lgamma(found + 0.5) + std::lgamma(count - found + 0.5) - std::lgamma(count + 1.0) - kLogPi;
}

}  // namespace

Recurrence recurrenceOf(const std::vector<bool>& found) {
  const std::size_t n = found.size();
  Recurrence best;
  if (n < 6) return best;
  std::vector<double> sum{0.0};
  for (const bool f : found) sum.push_back(sum.back() + (f ? 1.0 : 0.0));
  const auto part = [&](std::size_t a, std::size_t b) { return logEvidence(sum[b] - sum[a], b - a); };
  const auto share = [&](std::size_t a, std::size_t b) { return (sum[b] - sum[a]) / (b - a); };
  double once = kNever, twice = kNever, likeliest = kNever;
  double places = 0.0, pairs = 0.0;
  for (std::size_t i = 1; i < n; ++i) {
    once = logSum(once, part(0, i) + part(i, n));
    ++places;
    for (std::size_t j = i + 1; j < n; ++j) {
      ++pairs;
      if (!(share(0, i) > 0.5 && share(i, j) < 0.5 && share(j, n) > 0.5)) continue;
      const double here = part(0, i) + part(i, j) + part(j, n);
      twice = logSum(twice, here);
      if (here > likeliest) {
        likeliest = here;
        best.gone = i;
        best.back = j;
      }
    }
  }
  if (twice == kNever) return best;
  best.logOdds = twice - std::log(pairs) - std::max(part(0, n), once - std::log(places));
  return best;
}

}  // namespace mm
