// A controller of one's own: axes that go where they are told. What a real one would ask its hardware stands
// in `poll`; what must reach it at once is in `stop` and `emergencyStop`, which wait for nothing.
#include <measuring_machine/axis_controller.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <pluginlib/class_list_macros.hpp>

namespace own_controller {

class GlassScales final : public mm::AxisController {
 public:
  void open(const mm::ControllerSetup& setup) override {
    for (const auto& [name, value] : setup.parameters)
      throw std::invalid_argument("parameter '" + name + "' (" + value + ") is not known to glass_scales");
    for (const mm::ControllerAxis& axis : setup.axes) names_.push_back(axis.name);
    state_.position.assign(names_.size(), 0.0);
    state_.velocity.assign(names_.size(), 0.0);
    state_.axisHomed.assign(names_.size(), false);
    state_.actual = true;
  }
  void reconnect() override {}
  const std::vector<std::string>& axes() const override { return names_; }
  mm::Capabilities capabilities() const override {
    mm::Capabilities can;
    can.feedHold = can.homingByAxis = true;
    return can;
  }

  mm::AxesState poll(double elapsed) override {
    state_.time += elapsed;
    if (stop_.exchange(false) && state_.moving) end(mm::Outcome::kStopped);
    state_.emergencyStop = emergency_;
    state_.held = hold_ && state_.moving;
    std::fill(state_.velocity.begin(), state_.velocity.end(), 0.0);
    if (!state_.moving || hold_) return state_;
    bool there = true;
    for (std::size_t j = 0; j < names_.size(); ++j) {
      const double reach = motion_.speed[j] * elapsed;
      const double step = std::clamp(motion_.target[j] - state_.position[j], -reach, reach);
      state_.position[j] += step;
      if (elapsed > 0.0) state_.velocity[j] = step / elapsed;
      there = there && std::abs(motion_.target[j] - state_.position[j]) < 1e-12;
    }
    if (there) end(mm::Outcome::kReached);
    return state_;
  }

  void home(const std::vector<std::size_t>& axes) override {
    if (emergency_) throw std::runtime_error("emergency stop");
    for (const std::size_t j : axes) {
      state_.position[j] = 0.0;
      state_.axisHomed[j] = true;
    }
    state_.homed = std::all_of(state_.axisHomed.begin(), state_.axisHomed.end(), [](bool h) { return h; });
  }
  void move(const mm::AxesMotion& motion) override {
    motion_ = motion;
    stop_ = hold_ = false;
    state_.motion = motion.id;
    state_.outcome = mm::Outcome::kUnderWay;
    state_.moving = true;
  }
  void clearAlarm() override {}
  void resetEmergencyStop() override { emergency_ = false; }
  std::vector<mm::ProbeEdge> takeProbeEdges() override { return {}; }

  void stop() override { stop_ = true; }
  void emergencyStop() override { emergency_ = stop_ = true; }
  void feedHold(bool hold) override { hold_ = hold; }

 private:
  void end(mm::Outcome outcome) {
    state_.moving = false;
    state_.outcome = outcome;
    std::fill(state_.velocity.begin(), state_.velocity.end(), 0.0);
  }

  std::vector<std::string> names_;
  mm::AxesState state_;
  mm::AxesMotion motion_;
  std::atomic<bool> stop_{false}, emergency_{false}, hold_{false};
};

}  // namespace own_controller

PLUGINLIB_EXPORT_CLASS(own_controller::GlassScales, mm::AxisController)
