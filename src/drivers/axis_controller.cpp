#include "drivers/axis_controller.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/error.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kSlack = 1e-9;  // m or rad: a target at the limit is within it, whatever its last bit

}  // namespace

AxesMotion timedMotion(const std::vector<double>& from, const std::vector<double>& to, double seconds) {
  if (!(seconds > 0.0) || !std::isfinite(seconds))
    throw InputError("a motion must take longer than 0 s; state a speed above 0");
  AxesMotion motion;
  motion.target = to;
  for (std::size_t j = 0; j < to.size(); ++j) motion.speed.push_back(std::abs(to[j] - from[j]) / seconds);
  return motion;
}

AxesMotion straightMotion(const std::vector<Joint>& joints, const std::vector<double>& from,
                          const std::vector<double>& to, double linear, double rotary) {
  double seconds = 0.0;
  for (std::size_t j = 0; j < to.size(); ++j) {
    const double way = std::abs(to[j] - from[j]);
    if (way == 0.0) continue;
    const bool turns = joints[j].kind == JointKind::kRotary;
    double speed = turns ? rotary : linear;
    if (!(speed > 0.0))
      throw InputError("joint " + joints[j].name + ": its speed is " + std::to_string(speed) +
                       (turns ? " rad/s" : " m/s") + "; it must be above 0");
    if (joints[j].maxVelocity > 0.0) speed = std::min(speed, joints[j].maxVelocity);
    seconds = std::max(seconds, way / speed);
  }
  if (seconds == 0.0) return {to, std::vector<double>(to.size(), 0.0), false};
  return timedMotion(from, to, seconds);
}

void checkTarget(const std::vector<Joint>& joints, const std::vector<double>& target) {
  if (target.size() != joints.size())
    throw InputError("a target has " + std::to_string(target.size()) + " values for " +
                     std::to_string(joints.size()) + " joints");
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    if (!std::isfinite(target[j])) throw InputError("target of joint " + joint.name + " is not a number");
    if (!(joint.lower < joint.upper)) continue;
    if (target[j] >= joint.lower - kSlack && target[j] <= joint.upper + kSlack) continue;
    const bool turns = joint.kind == JointKind::kRotary;
    const double unit = turns ? kDegree : kMillimetre;
    char text[160];
    std::snprintf(text, sizeof text, "target %.6g %s is beyond the limits %.6g to %.6g of its URDF",
                  target[j] / unit, turns ? "deg" : "mm", joint.lower / unit, joint.upper / unit);
    throw InputError("joint " + joint.name + ": " + text);
  }
}

}  // namespace mm
