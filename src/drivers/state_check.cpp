#include "drivers/state_check.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

constexpr double kJumpSlack = 0.1e-3;      // m: what no axis jumps by without having lost its zero
constexpr double kJumpSlackTurn = 1.7e-3;  // rad, 0.1 deg
constexpr double kJitter = 0.05;           // s between a reading and its time stamp, in a busy controller
constexpr double kFaster = 1.5;            // times the highest speed: a controller may look ahead

}  // namespace

StateCheck::StateCheck(std::vector<Joint> joints, std::vector<AxisCapability> capabilities)
    : joints_(std::move(joints)), capabilities_(std::move(capabilities)) {}

std::string StateCheck::sizes(const AxesState& state) const {
  const std::size_t axes = joints_.size();
  const auto wrong = [&](const char* what, std::size_t size) {
    return "the controller gives " + std::to_string(size) + " " + what + " for " + std::to_string(axes) +
           " axes; does it belong to this machine?";
  };
  if (state.position.size() != axes) return wrong("positions", state.position.size());
  for (const auto& [what, size] :
       {std::pair("velocities", state.velocity.size()), std::pair("limit switches", state.limitSwitch.size()),
        std::pair("homing flags", state.axisHomed.size())})
    if (size != axes && size != 0) return wrong(what, size);
  for (std::size_t j = 0; j < axes; ++j)
    if (!std::isfinite(state.position[j]))
      return "the controller's position of " + joints_[j].name + " is not a number";
  if (!std::isfinite(state.time)) return "the controller's clock is not a number";
  return {};
}

std::string StateCheck::complaint(const AxesState& state) {
  jumped_ = false;
  std::string wrong = sizes(state);
  if (!wrong.empty()) return wrong;
  if (last_ && last_->resets == state.resets) {
    const double gone = state.time - last_->time;
    if (gone < 0.0) return format("the controller's clock went back by %.6g s", -gone);
    const bool comparable = last_->homed && state.homed;
    for (std::size_t j = 0; comparable && j < joints_.size(); ++j) {
      if (!(joints_[j].maxVelocity > 0.0)) continue;
      const bool turns = joints_[j].kind == JointKind::kRotary;
      const double resolution = j < capabilities_.size() ? capabilities_[j].resolution : 0.0;
      const double reach = kFaster * joints_[j].maxVelocity *
                               (gone + kJitter + state.timeUncertainty + last_->timeUncertainty) +
                           2.0 * resolution + (turns ? kJumpSlackTurn : kJumpSlack);
      const double way = state.position[j] - last_->position[j];
      if (std::abs(way) <= reach) continue;
      const JointUnit unit = readingUnit(joints_[j]);
      jumped_ = true;
      return format(
          "the position of %s jumped by %.6g %s within %.3g s, faster than its speed allows; its zero is "
          "uncertain, home again",
          joints_[j].name.c_str(), way / unit.factor, unit.symbol, gone);
    }
  }
  last_ = state;
  return {};
}

}  // namespace mm
