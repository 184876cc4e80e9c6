#include "drivers/axis_controller.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "base/error.h"
#include "base/format.h"
#include "machine/joint_units.h"

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
  static constexpr const char* kNames[] = {"under way", "reached", "tripped", "held",
                                           "limit",     "alarm",   "stopped", "lost"};
  const auto number = static_cast<std::size_t>(outcome);
  return number < std::size(kNames) ? kNames[number] : "unknown";  // a plugin may say anything
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
  return timedMotion(from, to, seconds > 0.0 ? seconds : 1.0);  // there already: however long that takes
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
    const JointUnit unit = readingUnit(joint);
    throw InputError("joint " + joint.name + ": " +
                     format("target %.6g %s is beyond the limits %.6g to %.6g of its URDF",
                            target[j] / unit.factor, unit.symbol, joint.lower / unit.factor,
                            joint.upper / unit.factor));
  }
}

void checkSpeeds(const std::vector<Joint>& joints, const AxesMotion& motion) {
  for (std::size_t j = 0; j < joints.size() && j < motion.speed.size(); ++j) {
    const Joint& joint = joints[j];
    if (!(motion.speed[j] >= 0.0) || !std::isfinite(motion.speed[j]))
      throw InputError("joint " + joint.name + ": its speed is not a number");
    if (!(joint.maxVelocity > 0.0) || motion.speed[j] <= joint.maxVelocity * (1.0 + kSlack)) continue;
    const JointUnit unit = readingUnit(joint);
    throw InputError(
        "joint " + joint.name + " " +
        format("would move at %.6g %s/s, its URDF allows %.6g; state a lower speed for this motion",
               motion.speed[j] / unit.factor, unit.symbol, joint.maxVelocity / unit.factor));
  }
}

}  // namespace mm
