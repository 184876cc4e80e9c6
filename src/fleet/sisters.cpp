#include "fleet/sisters.h"

#include <cmath>

#include "fleet/robust_numbers.h"
#include "fleet/trend.h"

namespace mm {

Sisterhood sistersOf(const std::vector<Sister>& sisters) {
  constexpr std::size_t kFewest = 4;
  constexpr double kEfficiency = 0.37;        // of a median deviation
  constexpr double kOfMedian = 1.5707963268;  // variance of a median over that of a mean: pi / 2
  Sisterhood all;
  all.p.assign(sisters.size(), 1.0);
  if (sisters.empty()) return all;
  std::vector<double> value, away, variance, total;
  for (const Sister& s : sisters) value.push_back(s.value);
  all.centre = middleOf(value);
  for (const Sister& s : sisters) {
    away.push_back(s.value - all.centre);
    variance.push_back(s.std * s.std);
  }
  all.spread = excessScatter(away, variance);
  for (const double v : variance) total.push_back(v + all.spread * all.spread);
  const auto count = static_cast<double>(sisters.size());
  const double ofCentre = kOfMedian * middleOf(total) / count;
  all.centreStd = std::sqrt(ofCentre);
  if (sisters.size() < kFewest) return all;
  for (std::size_t i = 0; i < sisters.size(); ++i) {
    const double expected = std::sqrt(total[i] + ofCentre);
    if (expected > 0.0) all.p[i] = twoSidedT(away[i] / expected, std::max(2.0, kEfficiency * (count - 1.0)));
  }
  return all;
}

}  // namespace mm
