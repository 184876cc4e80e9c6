#include "session/copied_rows.h"

#include <algorithm>
#include <cmath>

namespace mm {
namespace {

bool sameNumber(double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }

bool sameNumbers(const std::vector<double>& x, const std::vector<double>& y) {
  return std::equal(x.begin(), x.end(), y.begin(), y.end(), sameNumber);
}

bool sameRow(const Observation& a, const Observation& b) {
  bool reference = true;
  for (int k = 0; k < 3; ++k) reference = reference && sameNumber(a.reference[k], b.reference[k]);
  return a.kind == b.kind && a.feature == b.feature && a.setup == b.setup && a.time == b.time && reference &&
         sameNumber(a.laserReading, b.laserReading) && sameNumbers(a.position, b.position) &&
         sameNumbers(a.velocity, b.velocity) && sameNumbers(a.deviation, b.deviation) &&
         sameNumbers(a.deviationStd, b.deviationStd);
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> copiedRows(const std::vector<Observation>& observations) {
  std::vector<std::pair<std::size_t, std::size_t>> copies;
  std::vector<std::size_t> kept;  // of the time of the row at hand
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!kept.empty() && observations[kept.front()].time != observations[i].time) kept.clear();
    const auto same = std::find_if(kept.begin(), kept.end(),
                                   [&](std::size_t k) { return sameRow(observations[k], observations[i]); });
    if (same == kept.end())
      kept.push_back(i);
    else
      copies.emplace_back(i, *same);
  }
  return copies;
}

}  // namespace mm
