#include "fleet/sisters.h"

#include <algorithm>
#include <cmath>

#include "base/median.h"
#include "base/tiny.h"
#include "fleet/robust_numbers.h"

namespace mm {

namespace {

constexpr std::size_t kMostForPairs = 200;  // machines: beyond, a median deviation is known well enough

/// Spread between machines beyond their uncertainties, so that the deviations in units of both together have
/// the standard deviation 1 by `pairSpread`; 0 where they differ by less than stated.
double excessSpread(const std::vector<double>& away, const std::vector<double>& variance) {
  const auto tooSmall = [&](double spread) {
    std::vector<double> scaled;
    for (std::size_t i = 0; i < away.size(); ++i)
      scaled.push_back(away[i] / std::sqrt(variance[i] + spread * spread + kTiny));
    return pairSpread(scaled) > 1.0;
  };
  if (away.size() < 2) return 0.0;
  double high = 0.0;
  for (const double a : away) high = std::max(high, 10.0 * std::abs(a));
  constexpr int kHalvings = 30;  // to 1e-8 of the largest deviation
  return leastSpread(tooSmall, high, kHalvings);
}

/// Degrees of freedom of a Student's t that the deviation of a machine from the median, in units of the
/// spread, does not exceed more often; found by simulation of quiet fleets, down to a chance of 1e-5. Of
/// pairs they are about half of the machines, whose agreement by chance makes the spread small: of 10
/// machines 6.9 at 1e-5, of 7 machines 3.5.
double freedomsOf(std::size_t machines) {
  constexpr double kEfficiency = 0.37;  // of a median deviation
  constexpr std::size_t kFew = 10;
  return machines <= kMostForPairs ? machines / 2 + (machines < kFew ? 0 : 1)
                                   : kEfficiency * (machines - 1.0);
}

}  // namespace

Sisterhood sistersOf(const std::vector<Sister>& sisters) {
  constexpr std::size_t kFewest = 4;
  constexpr double kOfMedian = 1.5707963268;  // variance of a median over that of a mean: pi / 2
  Sisterhood all;
  all.p.assign(sisters.size(), 1.0);
  if (sisters.empty()) return all;
  std::vector<double> value, away, variance, total;
  for (const Sister& s : sisters) value.push_back(s.value);
  all.centre = median(value);
  for (const Sister& s : sisters) {
    away.push_back(s.value - all.centre);
    variance.push_back(s.std * s.std);
  }
  all.spread = sisters.size() <= kMostForPairs ? excessSpread(away, variance) : excessScatter(away, variance);
  for (const double v : variance) total.push_back(v + all.spread * all.spread);
  const double count = sisters.size();
  const double ofCentre = kOfMedian * median(total) / count;
  all.centreStd = std::sqrt(ofCentre);
  if (sisters.size() < kFewest) return all;
  for (std::size_t i = 0; i < sisters.size(); ++i) {
    const double expected = std::sqrt(total[i] + ofCentre);
    if (expected > 0.0) all.p[i] = twoSidedT(away[i] / expected, std::max(2.0, freedomsOf(sisters.size())));
  }
  return all;
}

}  // namespace mm
