#include "nodes/homing_watch.h"

#include <algorithm>

namespace mm {

bool HomingWatch::take(int joint, const Told& told) {
  Joint& j = joints_[joint];
  const bool same = j.byState && told.homed == j.told.homed && told.at == j.told.at;
  j.byState = j.known = true;
  j.told = told;
  return !same;
}

void HomingWatch::takeStatus(int joint, const Told& told) {
  Joint& j = joints_[joint];
  if (j.byState) return;
  j.known = true;
  j.told = told;
}

bool HomingWatch::isOf(int joint, std::int64_t at) const {
  const Joint& j = joints_[joint];
  return !j.byState || (j.told.homed && j.told.at == at);
}

bool HomingWatch::anyNotHomed() const {
  return std::any_of(joints_.begin(), joints_.end(), [](const Joint& j) { return j.known && !j.told.homed; });
}

std::int64_t HomingWatch::zero() const {
  std::int64_t last = 0;
  for (const Joint& j : joints_)
    if (j.known && j.told.homed) last = std::max(last, j.told.at);
  return last;
}

}  // namespace mm
