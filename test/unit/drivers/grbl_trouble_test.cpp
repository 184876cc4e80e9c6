// What keeps a grbl control from moving, as it does it, and the way out of each.
#include <gtest/gtest.h>

#include "grbl_fixture.h"

namespace mm {
namespace {

class GrblTroubleTest : public GrblTest {
 protected:
  /// A limit switch of x closes at the lower end, in motion.
  void runIntoTheLimit() {
    ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
    auto report = start({-60, 34, 36}, 0.02);
    double_->tell("limit 0 -1");
    const MotionControl::Report ended = report.get();
    EXPECT_EQ(ended.outcome, Outcome::kLimit) << ended.message;
    expectWords(ended.message, "alarm 1: a limit switch closed; call ~clear_alarm");
  }
  bool awaitAlarm(int code) {
    return await([&] { return control_->view().state.alarm.code == code; });
  }
};

// before: lost, and connected again without end
TEST_F(GrblTroubleTest, AControlThatWaitsForItsResetAfterALimitIsNotLost) {
  watchAsTheDriver();
  begin({"--no-hal"});
  runIntoTheLimit();
  // longer than it may be silent
  EXPECT_FALSE(await([&] { return !control_->view().lost.empty(); }, 3.0 * silence_));
  EXPECT_EQ(control_->view().state.alarm.code, 1);
  expectWords(refusal([&] { home(); }), "call ~clear_alarm first");
  EXPECT_EQ(refusal([&] { control_->stop("/panel"); }), "");
  EXPECT_EQ(refusal([&] { control_->clearAlarm(); }), "");
  home();
  double_->tell("limit 0 0");
}

TEST_F(GrblTroubleTest, GrblHalReportsInsteadAndStaysLockedOverAReset) {
  begin();
  runIntoTheLimit();
  expectWords(refusal([&] { home(); }), "call ~clear_alarm first");
  EXPECT_EQ(refusal([&] { control_->clearAlarm(); }), "");
  double_->tell("limit 0 0");
  home();
  EXPECT_EQ(go(kNear).outcome, Outcome::kReached);
}

TEST_F(GrblTroubleTest, ASwitchThatOpensIsAnAlarmOfGrblAndTheWayOffALimitGoesOn) {
  begin({"--no-hal"});
  runIntoTheLimit();
  control_->clearAlarm();
  auto off = std::async(std::launch::async, [&] {
    return refusal([&] { control_->moveOffLimit({"test", 0}); });
  });
  ASSERT_TRUE(await([&] { return double_->tell("machine")["moving"].get<bool>(); }));
  const double before = double_->tell("machine")["position"][0];
  double_->tell("limit 0 0");  // with which it raises ALARM:1 once more
  EXPECT_EQ(off.get(), "");
  EXPECT_TRUE(await([&] { return !control_->view().state.alarm.present(); })) << control_->view().fault;
  EXPECT_FALSE(control_->view().state.homed);
  EXPECT_GE(double_->tell("machine")["position"][0].get<double>(), before) << "away from the lower end";
  home();
}

TEST_F(GrblTroubleTest, WhichSwitchIsClosedIsNotGuessed) {
  begin();
  double_->tell("limit 0 -1");
  double_->tell("alarm 1");
  ASSERT_TRUE(awaitAlarm(1));
  control_->clearAlarm();
  const double before = double_->tell("machine")["position"][0];
  expectWords(refusal([&] {
                control_->moveOffLimit({"test", 0});
              }),
              "which of the two limit switches of x is closed is unknown");
  EXPECT_EQ(double_->tell("machine")["position"][0].get<double>(), before);
}

TEST_F(GrblTroubleTest, ATargetBeyondItsLimitsKeepsThePlace) {
  begin({"--no-hal"});
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("alarm 2");
  ASSERT_TRUE(awaitAlarm(2));
  control_->clearAlarm();
  EXPECT_EQ(go(kBeside).outcome, Outcome::kReached) << "still homed";
}

TEST_F(GrblTroubleTest, ItIsFoundAgainWhereItWaitsForItsReset) {
  std::vector<std::string> arguments = kDouble;
  arguments.emplace_back("--no-hal");
  double_ = std::make_unique<DeviceDouble>(arguments);
  double_->tell("alarm 1");  // before the driver began
  connect();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
}

// before: 146 mm for 10
TEST_F(GrblTroubleTest, ReportsInInchesAreRefused) {
  double_ = std::make_unique<DeviceDouble>(kDouble);
  double_->tell("set 13 1");
  GrblController controller;
  expectWords(
      refusal([&] {
        controller.open(controllerSetup(machine_, {{"address", double_->address()}, {"zero", kZero}}));
      }),
      "the control reports in inches ($13=1), mm are needed; set $13=0");
}

// before: "homing did not end: alarm 11", and the next one never ended
TEST_F(GrblTroubleTest, AxesHomeOneAfterAnotherWhereTheControlStaysLockedUntilAllHave) {
  double_ = std::make_unique<DeviceDouble>(kDouble);
  double_->tell("set 22 7");
  connect();
  EXPECT_TRUE(control_->capabilities().homingByAxis);
  control_->home({"z"}, {"test", 0});
  EXPECT_TRUE(control_->view().state.axisHomed[2]);
  EXPECT_FALSE(control_->view().state.homed);
  expectWords(refusal([&] { control_->clearAlarm(); }), "error 46: homing is required");
  for (const char* axis : {"x", "y", "a", "b", "c"}) control_->home({axis}, {"test", 0});
  EXPECT_TRUE(control_->view().state.homed);
  EXPECT_EQ(go(kNear).outcome, Outcome::kReached);
}

TEST_F(GrblTroubleTest, WithoutSingleAxesAllAreHomedTogetherAndItSaysSo) {
  double_ = std::make_unique<DeviceDouble>(kDouble);
  double_->tell("set 22 1");
  double_->tell("set 1 25");
  connect();
  const Capabilities can = control_->capabilities();
  EXPECT_FALSE(can.homingByAxis);
  std::string notes;
  for (const std::string& note : can.notes) notes += note + "\n";
  expectWords(notes, "single axes cannot be homed ($22 lacks 2)");
  expectWords(notes, "switched off 25 ms after a motion ($1)");
  home();
  EXPECT_TRUE(control_->view().state.homed);
}

// before: "cleared", and the alarm was there again half a second later
TEST_F(GrblTroubleTest, AnAlarmThatTheControlRefusesToClearIsNotCleared) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("refuse_x on");
  double_->tell("alarm 4");
  ASSERT_TRUE(awaitAlarm(4));
  expectWords(refusal([&] { control_->clearAlarm(); }),
              "not cleared: alarm 4: the probe was closed before the probing motion; the control refused to "
              "clear it, error 45: a limit switch is closed");
  EXPECT_EQ(control_->view().state.alarm.code, 4);
  double_->tell("refuse_x off");
  EXPECT_EQ(refusal([&] { control_->clearAlarm(); }), "");
  EXPECT_EQ(go(kBeside).outcome, Outcome::kReached);
}

// before: the motion never ended, and nothing said why
TEST_F(GrblTroubleTest, AnOpenDoorHoldsTheMotionAndSaysSo) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  auto report = start({12, 34, 36}, 0.02);
  double_->tell("door open");
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  expectWords(control_->view().fault, "the safety door is open");
  expectWords(refusal([&] { control_->hold(false); }), "the safety door is open");
  const double there = shown(0);
  double_->tell("door closed");
  ASSERT_TRUE(await([&] { return control_->view().fault.empty(); }));
  EXPECT_TRUE(control_->view().state.held);
  EXPECT_EQ(shown(0), there);
  control_->hold(false);
  EXPECT_EQ(report.get().outcome, Outcome::kReached);
  // and a stop gives the motion up: nothing goes on when the door closes
  report = start(kNear, 0.02);
  double_->tell("door open");
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->stop("/panel");
  EXPECT_EQ(report.get().outcome, Outcome::kStopped);
  expectWords(refusal([&] { go(kNear); }), "the safety door is open");
  const auto rests = double_->tell("machine")["position"];
  double_->tell("door closed");
  ASSERT_TRUE(await([&] { return control_->view().fault.empty() && !control_->view().state.moving; }));
  EXPECT_EQ(double_->tell("machine")["position"], rests);
  EXPECT_EQ(go(kNear).outcome, Outcome::kReached) << "still homed";
}

// before: "the controller was reset"
TEST_F(GrblTroubleTest, HomingThatFailsSaysWhy) {
  begin({"--no-hal"});
  double_->tell("homing_fails on");
  expectWords(refusal([&] { home(); }), "homing did not end: alarm 9: homing did not find the switch");
  double_->tell("homing_fails off");
  home();
}

// before: 40 mm/s for 20
TEST_F(GrblTroubleTest, AnOverrideAboveTheWholeIsTakenBack) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("override 2.0");
  ASSERT_TRUE(await([&] { return double_->tell("share")["share"] == 1.0; }));
  ASSERT_TRUE(await([&] { return control_->view().state.feedOverride == 1.0; }));
  double_->tell("override 0.5");  // an operator's right
  ASSERT_TRUE(await([&] { return control_->view().state.feedOverride == 0.5; }));
}

TEST_F(GrblTroubleTest, WhatAnotherSenderMovesIsSeenAndNotJoined) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("jog -20");
  ASSERT_TRUE(await([&] { return control_->view().state.moving; }));
  EXPECT_TRUE(await([&] { return control_->view().state.velocity[0] < 0.0; }));
  expectWords(refusal([&] { go(kBeside); }), "the axes still move");
  ASSERT_TRUE(await([&] { return !control_->view().state.moving; }, 10.0));
  EXPECT_EQ(go(kBeside).outcome, Outcome::kReached);
}

}  // namespace
}  // namespace mm
