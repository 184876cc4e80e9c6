#include "drivers/linuxcnc_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <future>
#include <sstream>

#include "base/error.h"
#include "motion_fixture.h"

namespace mm {
namespace {

/// LinuxCNC's double with X Y Z A B and a ball at x 20, y 30, z 10 mm.
class LinuxCncTest : public DeviceMotionFixture {
 protected:
  LinuxCncTest() : DeviceMotionFixture("test/ros/linuxcnc/machine.urdf") {}
  void SetUp() override {
    double_ = std::make_unique<DeviceDouble>(
        std::vector<std::string>{"test/doubles/linuxcnc_double.py", "--ball", "20", "30", "10", "5"});
    control(std::make_shared<LinuxCncController>(), {{"address", double_->address()},
                                                     {"coordinates", "XYZAB"},
                                                     {"poll_rate", "100"},
                                                     {"connect_timeout", std::to_string(kConnect)}});
  }
  void readyAt(const std::vector<double>& at) {
    ASSERT_TRUE(await([&] { return refusal([&] { control_->resetEmergencyStop(); }).empty(); }));
    const MotionControl::Report report = arrive(at);
    ASSERT_EQ(report.outcome, Outcome::kReached) << report.message << control_->view().fault;
  }
  double shown(std::size_t j) { return 1e3 * control_->view().state.position[j]; }
};

class LinuxCncFaultsTest : public LinuxCncTest {
 protected:
  LinuxCncFaultsTest() { late_ = MotionControl::Settings{}.late; }
};

TEST_F(LinuxCncTest, HomesGoesProbesStops) {
  expectWords(refusal([&] { control_->home({}, {"test", 0}); }), "emergency stop");
  readyAt({20, 30, 17});
  MotionControl::Report report = go({20, 30, 14}, 3e-3, true);
  ASSERT_EQ(report.outcome, Outcome::kTripped) << report.message;
  ASSERT_TRUE(await([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !edges_.empty();
  }));
  EXPECT_TRUE(edges_[0].probing && edges_[0].actual);
  EXPECT_NEAR(edges_[0].position[2], 16e-3, 5e-6) << "work offsets taken off";
  EXPECT_EQ(go({20, 30, 25}).outcome, Outcome::kReached);
  report = go({20, 30, 5});
  EXPECT_EQ(report.outcome, Outcome::kTripped);
  EXPECT_EQ(go({20, 30, 25}).outcome, Outcome::kReached);
  auto stopped = start({100, 30, 25}, 0.01);
  control_->stop("/panel");
  EXPECT_EQ(stopped.get().outcome, Outcome::kStopped);
  EXPECT_FALSE(double_->tell("machine")["moving"]);
  auto held = start({60, 30, 25}, 0.03);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->hold(false);
  report = held.get();
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
  EXPECT_EQ(refusal([&] { control_->home({"z"}, {"test", 0}); }), "");
}

TEST_F(LinuxCncTest, WhatIsSaidOfATripWhenTheNextMotionHasBegunIsNotOfThatOne) {
  readyAt({20, 30, 17});
  double_->tell("late");
  EXPECT_EQ(go({20, 30, 5}).outcome, Outcome::kTripped);
  const MotionControl::Report away = go({20, 30, 25});
  EXPECT_EQ(away.outcome, Outcome::kReached) << away.message;
  EXPECT_EQ(go({20, 30, 5}).outcome, Outcome::kTripped) << "and a trip of its own ends a motion as before";
}

// A busy computer holds up the task that tells where the axes are, not the axes.
TEST_F(LinuxCncTest, AStatusThatStoodStillWhileTheAxesWentOnIsNoLostZero) {
  readyAt({0, 0, 4});
  auto moving = start({-60, 0, 4});
  ASSERT_TRUE(await([&] { return shown(0) < -5.0; }));
  double_->tell("freeze 0.6");
  const MotionControl::Report report = moving.get();
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
  EXPECT_TRUE(control_->view().state.homed);
}

// Where motions must be watched more closely than that, such a motion is ended, and says why.
TEST_F(LinuxCncFaultsTest, AMotionWhoseStatusStandsStillIsNotWatched) {
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4});
  ASSERT_TRUE(await([&] { return shown(0) < -5.0; }));
  double_->tell("freeze 1.5");
  const MotionControl::Report report = moving.get();
  EXPECT_EQ(report.outcome, Outcome::kLost);
  expectWords(report.message, "states arrive");
  EXPECT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); }));
  EXPECT_LT(double_->tell("machine")["position"][0].get<double>(), -5.0);
  EXPECT_GT(double_->tell("machine")["position"][0].get<double>(), -85.0) << "stopped on its way";
}

TEST_F(LinuxCncTest, AStopThatIsRefusedIsSaidAgain) {
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4}, 0.01);
  double_->tell("refuse 3");
  control_->stop("/panel");
  EXPECT_EQ(moving.get().outcome, Outcome::kStopped);
  EXPECT_FALSE(double_->tell("machine")["moving"]);
  moving = start({-90, 0, 4}, 0.01);
  double_->tell("refuse 3");
  EXPECT_EQ(control_->emergencyStop("/panel"), "");
  EXPECT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); }));
  EXPECT_NE(moving.get().outcome, Outcome::kReached);
  // For ever refused: said, and the connections are made anew.
  double_->tell("refuse 1000");
  control_->emergencyStop("/panel");
  EXPECT_TRUE(await([&] { return control_->view().lost.find("refuses to ESTOP") != std::string::npos; }))
      << control_->view().lost;
}

// The flags of axes that were homed before stand until homing has begun.
TEST_F(LinuxCncTest, HomingAgainEndsWhenTheAxesAreHomedAgain) {
  readyAt({0, 0, 4});
  home();
  EXPECT_EQ(shown(2), 0.0) << "it has gone there";
  EXPECT_TRUE(control_->view().state.homed);
  const MotionControl::Report report = go({0, 0, 4});
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
}

TEST_F(LinuxCncFaultsTest, EveryFaultOfTheLineIsSaidAndTheEmergencyStopComesThrough) {
  const std::vector<std::pair<std::string, std::string>> faults = {{"off", "the connection ended"},
                                                                   {"stuck", "has given no state"},
                                                                   {"garbage", "no language of linuxcncrsh"},
                                                                   {"wrong", "the position of x jumped by"},
                                                                   {"slow", "late"},
                                                                   {"intermittent", "has given no state"}};
  for (const auto& [fault, words] : faults) {
    readyAt({0, 0, 4});
    auto report = start({-90, 0, 4}, 0.01);
    double_->tell("fault " + fault);
    const MotionControl::Report ended = report.get();
    std::printf("linuxcnc %s: %s, %s\n", fault.c_str(), outcomeName(ended.outcome).c_str(),
                ended.message.c_str());
    EXPECT_EQ(ended.outcome, Outcome::kLost) << fault;
    // of the watches of a silent line the one that bites first speaks
    EXPECT_TRUE(ended.message.find(words) != std::string::npos ||
                ended.message.find("has not answered") != std::string::npos ||
                ended.message.find("states arrive") != std::string::npos)
        << ended.message;
    EXPECT_FALSE(double_->tell("machine")["moving"]) << fault;
    const double asked = steadySeconds();
    const std::string failed = control_->emergencyStop("/panel");
    EXPECT_LT(steadySeconds() - asked, kLate) << fault;
    if (fault != "off") {
      EXPECT_EQ(failed, "") << fault;
      EXPECT_TRUE(await([&] {
        const auto machine = double_->tell("machine");
        return machine["told"].back()[0] == "reset" &&
               machine["told"].back()[1].get<double>() - asked < kLate;
      })) << fault;
    }
    double_->tell("fault ok");
    ASSERT_TRUE(await([&] { return control_->view().lost.empty(); }, 10.0))
        << fault << ": " << control_->view().lost;
  }
}

}  // namespace
}  // namespace mm
