#pragma once
#include <future>
#include <memory>
#include <thread>
#include <vector>

#include "fake_controller.h"
#include "motion_fixture.h"

namespace mm {

/// A fake controller under control, polled every millisecond by a thread, as the node does.
class FakeMotionFixture : public MotionFixture {
 protected:
  void SetUp() override { begin({}); }
  void begin(MotionControl::Settings settings) {
    finish();
    controller_ = std::make_shared<FakeController>();
    settings.silence = 1.0;
    settings.restTimeout = 1.5;
    settings.reconnect = 0.02;
    control_ = std::make_unique<MotionControl>(controller_, machine_, settings);
    ending_ = false;
    loop_ = std::thread([this] {
      auto next = FakeController::Wall::now();
      while (!ending_) {
        next += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(next);
        control_->cycle(1e-3, std::chrono::duration<double>(next.time_since_epoch()).count());
      }
    });
  }
  void finish() {
    if (!loop_.joinable()) return;
    ending_ = true;
    controller_->ended = true;
    loop_.join();
    control_.reset();
  }
  void TearDown() override { finish(); }

  AxesMotion to(const std::vector<double>& target, double speed = 0.02, bool probing = false) {
    AxesMotion motion =
        straightMotion(machine_.joints(), control_->view().state.position, target, speed, 1.0);
    motion.probing = probing;
    return motion;
  }
  MotionControl::Report go(const std::vector<double>& target, double speed = 0.02, bool probing = false) {
    return control_->move(to(target, speed, probing), {"test", 0}, control_->stops());
  }
  std::future<MotionControl::Report> start(const std::vector<double>& target, double speed = 0.002,
                                           bool probing = false) {
    const AxesMotion motion = to(target, speed, probing);
    const int before = controller_->moves;
    const std::uint32_t stops = control_->stops();
    auto report = std::async(std::launch::async, [this, motion, stops] {
      return control_->move(motion, {"test", 0}, stops);
    });
    EXPECT_TRUE(await([&] {
      const bool over = report.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
      return controller_->moves > before && (over || control_->view().state.moving);
    }));
    return report;
  }
  void home() { control_->home({}, {"test", 0}); }
  /// Homes, positions along x, and meets something on the way.
  MotionControl::Report meetSomething() {
    home();
    auto report = start({0.010, 0.0, 0.0});
    controller_->set([](AxesState& state) { state.probeClosed = true; });
    return report.get();
  }

  Machine machine_ = Machine::load("three_axis");
  std::shared_ptr<FakeController> controller_;
  std::unique_ptr<MotionControl> control_;
  std::atomic<bool> ending_{false};
  std::thread loop_;
};

}  // namespace mm
