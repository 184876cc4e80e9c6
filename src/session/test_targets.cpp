#include "session/test_targets.h"

#include <algorithm>
#include <cmath>

#include "base/tiny.h"

namespace mm {
namespace {

constexpr int kTargets = 5;     // at least, and a metre
constexpr double kShift = 0.3;  // of an interval at most, of a target

}  // namespace

int fewestTargets(double length) {
  return std::max(kTargets, static_cast<int>(std::ceil(kTargets * length - kOfAWhole)));
}

std::vector<double> shiftedTargets(int count, double span) {
  const double interval = span / (count - 1 + kShift);
  std::vector<double> at;
  for (int i = 0; i < count; ++i) {
    const double part = std::fmod(i * 0.618033988749895, 1.0);  // no two alike, and evenly spread
    at.push_back(interval * (i + kShift * part) - 0.5 * span);
  }
  return at;
}

}  // namespace mm
