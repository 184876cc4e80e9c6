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

ControllerSetup controllerSetup(const Machine& machine, AxisController::Parameters parameters) {
  ControllerSetup setup;
  setup.machine = machine.name();
  setup.urdf = machine.urdf();
  setup.parameters = std::move(parameters);
  for (const Joint& joint : machine.joints())
    setup.axes.push_back(
        {joint.name, joint.kind == JointKind::kRotary, joint.lower, joint.upper, joint.maxVelocity});
  return setup;
}

std::string outcomeName(Outcome outcome) {
  switch (outcome) {
    case Outcome::kUnderWay:
      return "under way";
    case Outcome::kReached:
      return "reached";
    case Outcome::kTripped:
      return "tripped";
    case Outcome::kHeld:
      return "held";
    case Outcome::kLimit:
      return "limit";
    case Outcome::kAlarm:
      return "alarm";
    case Outcome::kStopped:
      return "stopped";
    case Outcome::kLost:
      return "lost";
  }
  return "unknown";
}

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
  if (seconds == 0.0) {
    AxesMotion still;
    still.target = to;
    still.speed.assign(to.size(), 0.0);
    return still;
  }
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

void checkSpeeds(const std::vector<Joint>& joints, const AxesMotion& motion) {
  for (std::size_t j = 0; j < joints.size() && j < motion.speed.size(); ++j) {
    const Joint& joint = joints[j];
    const bool turns = joint.kind == JointKind::kRotary;
    const double unit = turns ? kDegree : kMillimetre;
    char text[160];
    if (!(motion.speed[j] >= 0.0) || !std::isfinite(motion.speed[j]))
      throw InputError("joint " + joint.name + ": its speed is not a number");
    if (!(joint.maxVelocity > 0.0) || motion.speed[j] <= joint.maxVelocity * (1.0 + kSlack)) continue;
    std::snprintf(text, sizeof text,
                  "would move at %.6g %s/s, its URDF allows %.6g; state a lower speed for this motion",
                  motion.speed[j] / unit, turns ? "deg" : "mm", joint.maxVelocity / unit);
    throw InputError("joint " + joint.name + " " + text);
  }
}

}  // namespace mm
