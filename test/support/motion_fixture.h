#pragma once
#include <gtest/gtest.h>

#include <atomic>
#include <fstream>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <sstream>
#include <thread>

#include "device_double.h"
#include "drivers/device_link.h"
#include "drivers/motion_control.h"

namespace mm {

/// s for a stop to come through on a computer that others share. One that waits behind what blocks the device
/// takes kConnect.
inline constexpr double kLate = 1.5;
inline constexpr double kConnect = 4.0;  // s for a device's first answers

/// What tests of motions ask for again and again.
class MotionFixture : public ::testing::Test {
 protected:
  /// @param seconds far beyond every watch of these tests, which is 5 s at most.
  static bool await(const std::function<bool()>& condition, double seconds = 20.0) {
    const double end = steadySeconds() + seconds;
    while (steadySeconds() < end) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return condition();
  }
  /// What the call throws, for people; empty: nothing.
  static std::string refusal(const std::function<void()>& call) {
    try {
      call();
    } catch (const std::exception& e) {
      return e.what();
    }
    return {};
  }
  static void expectWords(const std::string& text, const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << text;
  }
};

/// A controller that speaks to its double, under motion control, whose cycles a thread makes.
class DeviceMotionFixture : public MotionFixture {
 protected:
  explicit DeviceMotionFixture(const std::string& urdf) : machine_(read(urdf)) {}

  void control(const std::shared_ptr<AxisController>& controller,
               const AxisController::Parameters& parameters) {
    controller->open(controllerSetup(machine_, parameters));
    MotionControl::Settings settings;
    settings.reconnect = 0.1;
    settings.restTimeout = 1.5;
    settings.rotaryTolerance = 1e-4;
    settings.late = late_;
    settings.silence = silence_;
    control_ = std::make_unique<MotionControl>(controller, machine_, settings);
    cycle();
  }
  void cycle() {
    loop_ = std::thread([this] {
      while (!ending_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(4));
        const auto seen = control_->cycle(4e-3, steadySeconds());
        const std::lock_guard<std::mutex> lock(mutex_);
        if (seen) trips_.insert(trips_.end(), seen->trips.begin(), seen->trips.end());
      }
    });
  }
  void TearDown() override {
    ending_ = true;
    if (loop_.joinable()) loop_.join();
    control_.reset();
  }
  /// @param at mm of the linear joints, deg of those behind them; what is not said stays.
  AxesMotion to(const std::vector<double>& at, double speed, bool probing) {
    std::vector<double> target = control_->view().state.position;
    for (std::size_t j = 0; j < at.size(); ++j) target[j] = at[j] * (j < 3 ? 1e-3 : 3.14159265358979 / 180.0);
    AxesMotion motion =
        straightMotion(machine_.joints(), control_->view().state.position, target, speed, 0.7);
    motion.probing = probing;
    return motion;
  }
  MotionControl::Report go(const std::vector<double>& at, double speed = 0.04, bool probing = false) {
    return control_->move(to(at, speed, probing), {"test", 0}, control_->stops());
  }
  std::future<MotionControl::Report> start(const std::vector<double>& at, double speed = 0.04) {
    const AxesMotion motion = to(at, speed, false);
    const std::uint32_t stops = control_->stops();
    auto report = std::async(std::launch::async, [=] { return control_->move(motion, {"test", 0}, stops); });
    EXPECT_TRUE(await([&] { return double_->tell("machine")["moving"].get<bool>(); }));
    return report;
  }
  void home() { control_->home({}, {"test", 0}); }
  /// Homes and goes there; once more where the computer was held up for as long as a watch allows a device to
  /// be.
  MotionControl::Report arrive(const std::vector<double>& at) {
    MotionControl::Report report;
    report.outcome = Outcome::kLost;
    for (int i = 0; i < 3 && report.outcome == Outcome::kLost; ++i) {
      await([&] { return control_->view().lost.empty() && refusal([&] { home(); }).empty(); }, 10.0);
      report = go(at);
    }
    return report;
  }

  /// For the tests of the watches of a line: the driver's own limits. The others wait longer, for a computer
  /// that others share holds up a double and its line, too.
  void watchAsTheDriver() {
    const MotionControl::Settings driver;
    late_ = driver.late;
    silence_ = driver.silence;
    linkSilence_ = kLinkSilence;
  }

  double late_ = 5.0, silence_ = 5.0, linkSilence_ = 5.0;  // s; the last: the controller's `silence`
  Machine machine_;
  std::unique_ptr<DeviceDouble> double_;
  std::unique_ptr<MotionControl> control_;
  std::atomic<bool> ending_{false};
  std::mutex mutex_;
  std::vector<ProbeEdge> trips_;
  std::thread loop_;

 private:
  static Machine read(const std::string& urdf) {
    std::ifstream in(urdf);
    std::stringstream text;
    text << in.rdbuf();
    return Machine(text.str(), urdf);
  }
};

}  // namespace mm
