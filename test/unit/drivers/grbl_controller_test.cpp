#include "drivers/grbl_controller.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <future>
#include <sstream>

#include "base/error.h"
#include "grbl_fixture.h"

namespace mm {
namespace {

TEST(GrblProtocol, ReadsWhatIsDocumented) {
  const auto report =
      parseGrblReport("<Hold:0|MPos:1.000,-2.500,3.125|FS:500,0|WCO:0.000,1.500,0.000|Ov:90,100,100|Pn:XP>");
  ASSERT_TRUE(report);
  EXPECT_EQ(report->state, "Hold");
  EXPECT_EQ(report->substate, 0);
  EXPECT_EQ(report->machine, (std::vector<double>{1.0, -2.5, 3.125}));
  EXPECT_EQ(report->offset[1], 1.5);
  EXPECT_EQ(report->feedOverride, 90);
  EXPECT_EQ(report->pins, "XP");
  for (const char* bad : {"", "<>", "<Idle>", "<Idle|MPos:1.0,nan,2.0|FS:0,0>", "<Idle|MPos:1.0,,2.0>",
                          "Idle|MPos:1,2,3", "<Idle|MPos:1,2,3", "<:|MPos:1,2,3>", "<Idle|MPos:1e999,2,3>",
                          "<Idle|MPos:1,2,3|Ov:9.02222e54,100,100>", "<Hold:1e300|MPos:1,2,3>",
                          "<Idle|MPos:1,2,3|Ov:-1,100,100>"})
    EXPECT_FALSE(parseGrblReport(bad)) << bad;
  const auto probe = parseGrblProbe("[PRB:1.000,2.000,3.000,4.000,5.000,6.000:1]");
  ASSERT_TRUE(probe);
  EXPECT_TRUE(probe->tripped);
  EXPECT_EQ(probe->machine.size(), 6u);
  EXPECT_FALSE(parseGrblProbe("[PRB:1.000,2.000,3.000]"));
  EXPECT_FALSE(parseGrblProbe("[PRB:1.000,x,3.000:1]"));
  EXPECT_EQ(parseGrblAnswer("ok"), 0);
  EXPECT_EQ(parseGrblAnswer("error:9"), 9);
  EXPECT_FALSE(parseGrblAnswer("error:nine"));
  EXPECT_EQ(parseGrblAlarm("ALARM:1"), 1);
  EXPECT_EQ(parseGrblSetting("$110=500.000")->second, 500.0);
  EXPECT_EQ(grblOverride(0.67), std::string("\x90\x92\x92\x92\x94\x94\x94"));
  EXPECT_THROW(grblOverride(0.05), InputError);
}

TEST_F(GrblTest, SixAxesHomeGoAndProbe) {
  begin();
  const Capabilities can = control_->capabilities();
  EXPECT_NEAR(can.axes[0].acceleration, 0.5, 1e-9);
  EXPECT_NEAR(can.axes[3].upper, 40.0 * 3.14159265 / 180.0, 1e-6);
  EXPECT_TRUE(can.homingByAxis);
  expectWords(refusal([&] { go({0, 0, 0}); }), "not homed");
  home();
  for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(shown(j), 39.0, 1e-6) << "1 mm off its switch";
  MotionControl::Report report = go({20, 30, 38, 10, -20, 30});
  ASSERT_EQ(report.outcome, Outcome::kReached) << report.message;
  EXPECT_NEAR(shown(2), 38.0, 1e-6);
  EXPECT_NEAR(control_->view().state.position[4], -20.0 * 3.14159265358979 / 180.0, 1e-9);
  report = go({20, 30, 17, 10, -20, 30});
  ASSERT_EQ(report.outcome, Outcome::kReached) << report.message;
  report = go({20, 30, 14, 10, -20, 30}, 3e-3, true);
  ASSERT_EQ(report.outcome, Outcome::kTripped) << report.message;
  ASSERT_TRUE(await([&] {  // the cycle that said so hands it over
    const std::lock_guard<std::mutex> lock(mutex_);
    return !trips_.empty();
  }));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    EXPECT_TRUE(trips_[0].closed && trips_[0].probing);
    EXPECT_FALSE(trips_[0].actual);
    EXPECT_NEAR(trips_[0].position[2], 16e-3, 5e-6)
        << "radius 5 and tip 1 mm above z 10; a millisecond at 3 mm/s";
    EXPECT_NEAR(trips_[0].velocity[2], -3e-3, 1e-9);
    EXPECT_GT(trips_[0].timeUncertainty, 0.0);
  }
  EXPECT_TRUE(control_->view().state.probeClosed);
  EXPECT_EQ(go({20, 30, 25, 10, -20, 30}).outcome, Outcome::kReached) << "away from it";
  // Nothing there: reached, and no alarm.
  report = go({-20, 30, 14, 10, -20, 30}, 0.04, true);
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
  EXPECT_FALSE(control_->view().state.alarm.present());
}

TEST_F(GrblTest, TheControlItselfStopsWherePositioningMeetsTheBall) {
  begin();
  ASSERT_EQ(arrive({20, 30, 38}).outcome, Outcome::kReached);
  const MotionControl::Report report = go({20, 30, 0}, 0.04);
  EXPECT_EQ(report.outcome, Outcome::kTripped);
  expectWords(report.message, "the probe tripped while positioning");
  const double deep = double_->tell("machine")["deepest"];
  EXPECT_LT(deep, 2.0) << "mm; the way to rest from 40 mm/s with 500 mm/s^2 is 1.6";
}

TEST_F(GrblTest, StopRestsKeepsThePositionAndHoming) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  auto report = start({-60, 34, 36}, 0.02);
  control_->stop("/panel");
  EXPECT_EQ(report.get().outcome, Outcome::kStopped);
  const auto there = double_->tell("machine");
  EXPECT_FALSE(there["moving"]);
  EXPECT_NEAR(shown(0), there["position"][0].get<double>() + 40.0, 2e-3);
  const auto after = go(kNear);
  EXPECT_EQ(after.outcome, Outcome::kReached) << after.message << ": still homed";
  for (int i = 0; i < 5; ++i) control_->stop("/panel");  // at rest, again and again
  EXPECT_EQ(go(kBeside).outcome, Outcome::kReached);
  std::thread homing([&] { expectWords(refusal([&] { home(); }), "stopped by /panel"); });
  ASSERT_TRUE(
      await([&] { return control_->view().homing && double_->tell("machine")["moving"].get<bool>(); }));
  control_->stop("/panel");
  homing.join();
  EXPECT_FALSE(double_->tell("machine")["moving"]);
  EXPECT_FALSE(control_->view().state.homed);
}

TEST_F(GrblTest, AReportFromBeforeAStopDoesNotEndIt) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  for (int i = 0; i < 4; ++i) {
    // More than one question is open then; what answers the second one left the control before the stop. What
    // is later than a question waits is taken for the answer to the next one. The stop comes before the
    // answer to the first question, or after it.
    double_->tell(i < 2 ? "fault slow" : "fault slow 0.55");
    ASSERT_TRUE(await([&] { return double_->tell("line")["waiting"] >= 2; }));
    if (i % 2 == 1) {
      ASSERT_TRUE(await([&] { return double_->tell("line")["waiting"] == 1; }));
    }
    refusal([&] { control_->stop("/panel"); });
    double_->tell("fault ok");
    ASSERT_TRUE(await([&] { return control_->view().lost.empty() && !control_->view().state.moving; }, 10.0));
    const auto report = go(i % 2 == 0 ? kBeside : kNear);
    ASSERT_EQ(report.outcome, Outcome::kReached) << i << ": " << report.message;
  }
}

TEST_F(GrblTest, AFeedHoldThatNobodyWaitsForIsEnded) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("hold");
  ASSERT_TRUE(await([&] {
    const auto told = double_->tell("machine")["told"];
    return told.back()[0] == "reset";
  }));
  ASSERT_TRUE(await([&] { return refusal([&] { go(kBeside); }).empty(); }));
  EXPECT_NEAR(shown(0), kBeside[0], 1e-3) << "it went there";
}

TEST_F(GrblTest, HoldResumeOverride) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  control_->setOverride(0.5);
  auto report = start({12, 34, 36}, 0.02);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  const double there = shown(0);
  const int heard = double_->tell("line")["heard"];
  ASSERT_TRUE(await([&] { return double_->tell("line")["heard"] > heard + 10; })) << "reports go on";
  EXPECT_EQ(shown(0), there);
  control_->hold(false);
  EXPECT_EQ(report.get().outcome, Outcome::kReached);
  EXPECT_TRUE(await([&] { return control_->view().state.feedOverride == 0.5; }));
}

TEST_F(GrblTest, AlarmsLimitsAndTheWayOut) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  double_->tell("limit 0 1");
  const MotionControl::Report report = go({38, 34, 36});
  EXPECT_EQ(report.outcome, Outcome::kLimit);
  expectWords(report.message, "alarm 1: a limit switch closed");
  expectWords(refusal([&] { go(kNear); }), "alarm 1");
  control_->clearAlarm();
  auto off = std::async(std::launch::async, [&] {
    return refusal([&] { control_->moveOffLimit({"test", 0}); });
  });
  ASSERT_TRUE(await([&] { return double_->tell("machine")["moving"].get<bool>(); }));
  double_->tell("limit 0 0");
  EXPECT_EQ(off.get(), "");
  EXPECT_FALSE(control_->view().state.homed);
  home();
  EXPECT_EQ(go(kNear).outcome, Outcome::kReached);
  double_->tell("alarm 3");
  ASSERT_TRUE(await([&] { return control_->view().state.alarm.code == 3; }));
  control_->clearAlarm();
  expectWords(refusal([&] { go(kNear); }), "not homed");
}

TEST_F(GrblTest, EmergencyStopReachesTheControlWhateverItDoes) {
  begin();
  ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached);
  for (const char* fault : {"ok", "stuck", "garbage", "slow", "intermittent"}) {
    auto report = start({-60, 34, 36}, 0.02);
    double_->tell(std::string("fault ") + fault);
    const int before = double_->tell("line")["heard"];
    ASSERT_TRUE(await([&] { return double_->tell("line")["heard"] > before + 1; })) << "asked again under it";
    const double asked = steadySeconds();
    EXPECT_EQ(control_->emergencyStop("/panel"), "") << fault;
    ASSERT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); })) << fault;
    report.get();
    double heard = 0.0;
    const auto machine = double_->tell("machine");
    for (const auto& told : machine["told"])
      if (told[0] == "reset" && told[1].get<double>() >= asked && heard == 0.0)
        heard = told[1].get<double>() - asked;
    EXPECT_GT(heard, 0.0) << fault;
    EXPECT_LT(heard, kLate) << fault;
    std::printf("emergency stop, device %s: heard after %.2f ms\n", fault, 1e3 * heard);
    double_->tell("fault ok");
    ASSERT_TRUE(await([&] { return control_->view().lost.empty() && !control_->view().state.moving; }, 8.0))
        << fault << control_->view().lost;
    control_->resetEmergencyStop();
    expectWords(refusal([&] { go(kNear); }), "home");  // "not homed", or "alarm 3 … home again"
    ASSERT_EQ(arrive(kNear).outcome, Outcome::kReached) << fault;
  }
}

TEST_F(GrblTest, EveryFaultOfTheLineIsSaidAndNothingMovesThatShouldNot) {
  const std::vector<std::pair<std::string, std::string>> faults = {{"off", "the connection ended"},
                                                                   {"stuck", "no status report for"},
                                                                   {"garbage", "not grbl protocol"},
                                                                   {"wrong", "the position of x jumped by"},
                                                                   {"slow", "late"},
                                                                   {"intermittent", "no status report for"}};
  watchAsTheDriver();
  begin();
  for (const auto& [fault, words] : faults) {
    const MotionControl::Report went = arrive(kNear);
    ASSERT_EQ(went.outcome, Outcome::kReached) << fault << ": " << went.message;
    auto report = start({-95, 34, 36}, 0.01);
    double_->tell("fault " + fault);
    const MotionControl::Report ended = report.get();
    std::printf("grbl %s: %s, %s\n", fault.c_str(), outcomeName(ended.outcome).c_str(),
                ended.message.c_str());
    EXPECT_EQ(ended.outcome, Outcome::kLost) << fault;
    // of the watches of a silent line the one that bites first speaks
    EXPECT_TRUE(ended.message.find(words) != std::string::npos ||
                ended.message.find("has not answered") != std::string::npos ||
                ended.message.find("states arrive") != std::string::npos)
        << ended.message;
    EXPECT_FALSE(double_->tell("machine")["moving"]) << fault;
    double_->tell("fault ok");
    ASSERT_TRUE(await([&] { return control_->view().lost.empty() && !control_->view().state.moving; }, 8.0))
        << fault << ": " << control_->view().lost;
    const std::string refused = refusal([&] { go(kBeside); });
    if (fault == "slow")  // late, but never wrong: its zero still holds
      EXPECT_EQ(refused, "");
    else
      expectWords(refused, "homed");
  }
}

TEST_F(GrblTest, APtyIsASerialLine) {
  begin({"--pty", "--no-hal"});
  EXPECT_FALSE(control_->capabilities().homingByAxis);
  home();
  EXPECT_EQ(go({0, 0, 20}).outcome, Outcome::kReached);
}

TEST(GrblController, SaysWhatIsWrongWithItsParameters) {
  const Machine machine = Machine::load("three_axis");
  const std::vector<std::pair<AxisController::Parameters, std::string>> wrong = {
      {{}, "parameter 'address' of the grbl controller is missing"},
      {{{"address", "udp:1"}}, "neither tcp:"},
      {{{"address", "tcp:127.0.0.1"}}, "no port"},
      {{{"address", "tcp:127.0.0.1:99999"}}, "from 1 to 65535"},
      {{{"address", "serial:/dev/nosuch"}}, "/dev/nosuch: cannot be opened"},
      {{{"address", "tcp:127.0.0.1:1"}}, "tcp:127.0.0.1:1: cannot be opened"},
      {{{"address", "tcp:127.0.0.1:1"}, {"axes", "x:Q"}}, "'Q' is not an axis of this controller"},
      {{{"address", "tcp:127.0.0.1:1"}, {"axes", "x:X y:X"}}, "moves two joints"},
      {{{"address", "tcp:127.0.0.1:1"}, {"sign", "x:2"}}, "must be 1 or -1"},
      {{{"adress", "tcp:127.0.0.1:1"}}, "'adress' is not known to the grbl controller"}};
  for (const auto& [parameters, words] : wrong) {
    try {
      GrblController controller;
      controller.open(controllerSetup(machine, parameters));
      FAIL() << words;
    } catch (const std::exception& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  }
}

}  // namespace
}  // namespace mm
