#pragma once
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <vector>

#include "drivers/axis_controller.h"

namespace mm {

/// Three axes without physics: goes where it is told at the speed it is told, and does what a test wants
/// wrong.
class FakeController final : public AxisController {
 public:
  using Wall = std::chrono::steady_clock;

  void open(const ControllerSetup&) override {}
  void reconnect() override {
    if (away) throw std::runtime_error("away");
    ++reconnects;
    down_ = false;
  }
  const std::vector<std::string>& axes() const override { return names_; }
  Capabilities capabilities() const override {
    Capabilities can;
    can.feedHold = can.feedOverride = can.moveOffLimit = true;
    can.homingByAxis = homesByAxis;
    return can;
  }
  AxesState poll(double elapsed) override {
    while (block && !ended) {
      blocked = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    blocked = false;
    if (away) down_ = true;
    if (down_) throw std::runtime_error("the cable is out");
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!frozen) state_.time += elapsed;
    if (stop_.exchange(false) && state_.moving) finish(Outcome::kStopped);
    if (state_.moving && !hold_) advance(elapsed);
    AxesState told = state_;
    told.held = hold_ && state_.moving;
    if (change) change(told);
    return told;
  }
  void home(const std::vector<std::size_t>& axes) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    homed.push_back(axes);
    motion_ = AxesMotion();
    motion_.target = state_.position;
    motion_.speed.assign(3, 0.01);
    for (const std::size_t j : axes) motion_.target[j] = 0.0;
    state_.moving = true;
    state_.outcome = Outcome::kUnderWay;
    homing_ = axes;
  }
  void move(const AxesMotion& motion) override {
    if (beforeMove) beforeMove();
    const std::lock_guard<std::mutex> lock(mutex_);
    motion_ = motion;
    leaving = motion.leaving;
    ++moves;
    fastest = std::max(fastest, *std::max_element(motion.speed.begin(), motion.speed.end()));
    state_.motion = motion.id;
    state_.moving = true;
    state_.outcome = Outcome::kUnderWay;
  }
  void clearAlarm() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_.alarm = {};
  }
  void moveOffLimit() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    state_.limitSwitch.assign(3, 0);
  }
  void resetEmergencyStop() override {
    if (beforeReset) beforeReset();
    const std::lock_guard<std::mutex> lock(mutex_);
    state_.emergencyStop = false;
  }
  std::vector<ProbeEdge> takeProbeEdges() override { return {}; }
  void stop() override {
    ++stops;
    stop_ = true;
  }
  void emergencyStop() override {
    emergencyAt = Wall::now();
    ++emergencies;
    stop_ = true;
  }
  void feedHold(bool hold) override { hold_ = hold; }
  std::vector<std::pair<std::string, double>> temperatures() override {
    while (blockTemperatures && !ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return {};
  }

  /// Changes the state between two polls.
  void set(const std::function<void(AxesState&)>& changed) {
    const std::lock_guard<std::mutex> lock(mutex_);
    changed(state_);
  }

  std::atomic<bool> block{false}, blocked{false}, ended{false}, away{false}, frozen{false}, homesByAxis{true};
  std::atomic<bool> blockTemperatures{false};
  std::atomic<bool> leaving{false};  // the last motion, as it was told
  std::atomic<int> stops{0}, emergencies{0}, moves{0}, reconnects{0};
  std::atomic<Wall::time_point> emergencyAt{Wall::time_point()};
  double fastest = 0.0;
  double shortBy = 0.0;  // m that x stays away from its target, and says it arrived
  std::vector<std::vector<std::size_t>> homed;
  std::function<void()> beforeMove, beforeReset;
  std::function<void(AxesState&)> change;  // of what is told
  static AxesState start() {
    AxesState state;
    state.position.assign(3, 0.002);
    state.velocity.assign(3, 0.0);
    state.limitSwitch.assign(3, 0);
    state.axisHomed.assign(3, false);
    return state;
  }

 private:
  void finish(Outcome outcome) {
    state_.moving = false;
    state_.outcome = outcome;
    state_.velocity.assign(3, 0.0);
    homing_.clear();
  }
  void advance(double elapsed) {
    bool there = true;
    for (std::size_t j = 0; j < 3; ++j) {
      const double target = motion_.target[j] - (j == 0 ? shortBy : 0.0);
      const double reach = motion_.speed[j] * elapsed, left = target - state_.position[j];
      state_.position[j] += std::clamp(left, -reach, reach);
      state_.velocity[j] = left == 0.0 ? 0.0 : std::copysign(motion_.speed[j], left);
      there = there && state_.position[j] == target;
    }
    if (!there) return;
    for (const std::size_t j : homing_) state_.axisHomed[j] = true;
    state_.homed = state_.axisHomed[0] && state_.axisHomed[1] && state_.axisHomed[2];
    finish(Outcome::kReached);
  }

  std::vector<std::string> names_ = {"x", "y", "z"};
  std::mutex mutex_;
  AxesState state_ = start();
  AxesMotion motion_;
  std::vector<std::size_t> homing_;
  std::atomic<bool> stop_{false}, hold_{false}, down_{false};
};

}  // namespace mm
