#include "drivers/motion_control.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "fake_motion_fixture.h"

namespace mm {
namespace {

using Wall = std::chrono::steady_clock;
using MotionControlTest = FakeMotionFixture;

TEST_F(MotionControlTest, ReachedIsWhatTheReadingsSay) {
  home();
  MotionControl::Report report = go({0.001, 0.0, 0.0});
  EXPECT_EQ(report.outcome, Outcome::kReached);
  EXPECT_EQ(report.position[0], 0.001);
  controller_->shortBy = 50e-6;  // and the controller says that it arrived
  report = go({0.003, 0.0, 0.0});
  EXPECT_EQ(report.outcome, Outcome::kAlarm);
  expectWords(report.message, "x stopped -0.05 mm from its target 3 mm (tolerance");
}

TEST_F(MotionControlTest, NoMotionBeforeHomingNorAfterAReset) {
  expectWords(refusal([&] { go({0, 0, 0}); }), "not homed");
  home();
  EXPECT_EQ(go({0.001, 0, 0}).outcome, Outcome::kReached);
  controller_->set([](AxesState& state) { ++state.resets; });
  ASSERT_TRUE(await([&] { return !control_->view().state.homed; }));
  expectWords(refusal([&] { go({0, 0, 0}); }), "not homed");
}

TEST_F(MotionControlTest, EveryMotionIsWithinTheSpeedsOfTheUrdf) {
  home();
  AxesMotion fast = timedMotion({0, 0, 0}, {0, 0, 0.003}, 1e-3);  // 3000 mm/s
  fast.probing = true;
  expectWords(refusal([&] {
                control_->move(fast, {"test", 0}, control_->stops());
              }),
              "joint z would move at 3000 mm/s, its URDF allows 20");
  EXPECT_EQ(controller_->moves, 0);
}

TEST_F(MotionControlTest, StopEndsTheMotionAndAnswersAtRest) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  control_->stop("/panel");
  EXPECT_FALSE(control_->view().state.moving);
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kStopped);
  expectWords(ended.message, "stopped by /panel");
}

TEST_F(MotionControlTest, AStopIsNeverLost) {
  home();
  // In the middle of the controller's own call that starts the motion, a hundred times.
  for (int i = 0; i < 100; ++i) {
    std::thread panel;
    controller_->beforeMove = [&] {
      panel = std::thread([&] { refusal([&] { control_->stop("/panel"); }); });
      while (controller_->stops == 0) std::this_thread::yield();
    };
    controller_->stops = 0;
    const MotionControl::Report report = go({i % 2 == 0 ? 0.010 : 0.0, 0.0, 0.0}, 0.002);
    controller_->beforeMove = nullptr;
    panel.join();
    ASSERT_EQ(report.outcome, Outcome::kStopped) << i;
    ASSERT_FALSE(control_->view().state.moving);
  }
  // Between the wish and its execution.
  const std::uint32_t before = control_->stops();
  control_->stop("/panel");
  expectWords(refusal([&] { control_->move(to({0.001, 0, 0}), {"test", 0}, before); }), "stopped by /panel");
}

TEST_F(MotionControlTest, ATicketEndsWithAStop) {
  home();
  const std::uint64_t ticket = control_->owner().take({"plan", 0}, 10.0);
  EXPECT_EQ(control_->owner().owner(), "plan");
  EXPECT_EQ(control_->move(to({0.001, 0, 0}), {"plan", ticket}, control_->stops()).outcome,
            Outcome::kReached);
  expectWords(refusal([&] { go({0.002, 0, 0}); }), "the axes belong to 'plan'");
  expectWords(refusal([&] { home(); }), "the axes belong to 'plan'");
  expectWords(refusal([&] { control_->owner().take({"other", 0}, 1.0); }), "the axes belong to 'plan'");
  control_->stop("/panel");
  expectWords(refusal([&] {
                control_->move(to({0.002, 0, 0}), {"plan", ticket}, control_->stops());
              }),
              "the ticket of 'plan' is no longer valid: stopped by /panel");
  EXPECT_EQ(go({0.002, 0, 0}).outcome, Outcome::kReached);
  const std::uint64_t brief = control_->owner().take({"plan", 0}, 0.01);
  EXPECT_TRUE(await([&] { return control_->owner().owner().empty(); }));
  expectWords(refusal([&] {
                control_->owner().take({"plan", brief}, 1.0);
              }),
              "it was not renewed for 0.01 s");
}

TEST_F(MotionControlTest, ATripWhilePositioningStopsAllAxes) {
  home();
  auto report = start({0.010, 0.010, 0.0});
  controller_->set([](AxesState& state) { state.probeClosed = true; });
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kTripped);
  expectWords(ended.message, "the probe tripped while positioning at x ");
  EXPECT_GE(controller_->stops, 1);
  const double there = ended.position[0];
  EXPECT_LT(there, 0.009);
  // It may leave, but not go on into the surface.
  auto away = start({0.0, 0.0, 0.0});
  controller_->set([](AxesState& state) { state.probeClosed = false; });
  EXPECT_EQ(away.get().outcome, Outcome::kReached);
  controller_->set([](AxesState& state) { state.probeClosed = true; });
  ASSERT_TRUE(await([&] { return control_->view().state.probeClosed; }));
  const MotionControl::Report into = go({0.010, 0.0, 0.0}, 0.01);
  EXPECT_EQ(into.outcome, Outcome::kTripped);
  expectWords(into.message, "the probe stayed closed");
  EXPECT_LT(into.position[0], 0.0025);
}

// before: each of these was counted from where it began
TEST_F(MotionControlTest, SeveralShortMotionsDoNotLeadIntoASurfaceEither) {
  const MotionControl::Report trip = meetSomething();
  ASSERT_EQ(trip.outcome, Outcome::kTripped);
  MotionControl::Report further;
  for (int i = 1; i <= 4 && further.outcome == Outcome::kReached; ++i)
    further = go({trip.position[0] + 1.5e-3 * i, 0.0, 0.0}, 0.01);
  EXPECT_EQ(further.outcome, Outcome::kTripped);
  expectWords(further.message, "the probe stayed closed over 2");
  EXPECT_LT(further.position[0] - trip.position[0], 2.5e-3);
  // out of it, and in again: it counts from there
  auto away = start({0.0, 0.0, 0.0});
  controller_->set([](AxesState& state) { state.probeClosed = false; });
  EXPECT_EQ(away.get().outcome, Outcome::kReached);
}

TEST_F(MotionControlTest, WhoeverStandsDeepAfterAFastCollisionMayLeave) {
  ASSERT_EQ(meetSomething().outcome, Outcome::kTripped);
  for (int i = 0; i < 75; ++i) {  // the way to rest, 3 mm
    const double before = control_->view().state.position[0];
    controller_->set([](AxesState& state) { state.position[0] += 40e-6; });
    ASSERT_TRUE(await([&] { return control_->view().state.position[0] > before; }));
  }
  const double deep = control_->view().state.position[0];
  const MotionControl::Report further = go({deep + 1e-3, 0.0, 0.0}, 0.01);
  EXPECT_EQ(further.outcome, Outcome::kTripped) << "further in";
  auto away = start({0.0, 0.0, 0.0}, 0.01);
  ASSERT_TRUE(await([&] { return control_->view().state.position[0] < deep - 1e-3; }));
  controller_->set([](AxesState& state) { state.probeClosed = false; });
  const MotionControl::Report left = away.get();
  EXPECT_EQ(left.outcome, Outcome::kReached) << left.message;
}

TEST_F(MotionControlTest, ThePlaceOfASurfaceIsOfItsZero) {
  ASSERT_EQ(meetSomething().outcome, Outcome::kTripped);
  controller_->set([](AxesState& state) {  // it begins anew, and counts from where it stands
    ++state.resets;
    state.position = {0.5e-3, 0.0, 0.0};
    state.axisHomed.assign(3, false);
  });
  ASSERT_TRUE(await([&] { return !control_->view().state.homed; }));
  home();  // half a millimetre, and the probe closed
  EXPECT_TRUE(control_->view().state.homed);
}

// before: "it is unknown whether the axes have stopped", after 5 s
TEST_F(MotionControlTest, StopAnswersBesideAnEncoderThatDithers) {
  home();
  std::atomic<int> polls{0};
  controller_->change = [&](AxesState& told) {  // a tenth of a micrometre, up and down
    const double sign = ++polls % 2 ? 1.0 : -1.0;
    for (double& p : told.position) p += sign * 5e-8;
    told.velocity.assign(3, sign * 10e-6);
  };
  auto report = start({0.010, 0.0, 0.0});
  EXPECT_EQ(refusal([&] { control_->stop("/panel"); }), "");
  EXPECT_EQ(report.get().outcome, Outcome::kStopped);
  EXPECT_EQ(refusal([&] { control_->stop("/panel"); }), "") << "at rest";
  finish();
}

// A switch that chatters is open when it is asked for, and closed when the controller begins.
TEST_F(MotionControlTest, TheMotionAfterATripLeavesASurfaceWhateverTheSwitchSaysNow) {
  home();
  ASSERT_EQ(go({0.001, 0.0, 0.0}).outcome, Outcome::kReached);
  EXPECT_FALSE(controller_->leaving);
  auto report = start({0.010, 0.0, 0.0});
  controller_->set([](AxesState& state) { state.probeClosed = true; });
  ASSERT_EQ(report.get().outcome, Outcome::kTripped);
  controller_->set([](AxesState& state) { state.probeClosed = false; });
  ASSERT_TRUE(await([&] { return !control_->view().state.probeClosed; }));
  ASSERT_EQ(go({0.001, 0.0, 0.0}).outcome, Outcome::kReached);
  EXPECT_TRUE(controller_->leaving);
  ASSERT_EQ(go({0.003, 0.0, 0.0}).outcome, Outcome::kReached);
  EXPECT_FALSE(controller_->leaving) << "it has left";
  auto again = start({0.010, 0.0, 0.0});
  controller_->set([](AxesState& state) { state.probeClosed = true; });
  ASSERT_EQ(again.get().outcome, Outcome::kTripped);
  controller_->set([](AxesState& state) { state.probeClosed = false; });
  ASSERT_TRUE(await([&] { return !control_->view().state.probeClosed; }));
  home();
  ASSERT_EQ(go({0.003, 0.0, 0.0}).outcome, Outcome::kReached);
  EXPECT_FALSE(controller_->leaving) << "it was homed since";
}

TEST_F(MotionControlTest, AnEmergencyStopWaitsForNothing) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  controller_->block = true;  // its poll does not return
  ASSERT_TRUE(await([&] { return controller_->blocked.load(); }));
  std::vector<std::thread> crowd;
  for (int i = 0; i < 5; ++i) crowd.emplace_back([&] { refusal([&] { home(); }); });
  for (int i = 0; i < 5; ++i) crowd.emplace_back([&] { refusal([&] { control_->clearAlarm(); }); });
  const auto asked = Wall::now();
  EXPECT_EQ(control_->emergencyStop("/panel"), "");
  const auto answered = Wall::now();
  const double reached = std::chrono::duration<double>(controller_->emergencyAt.load() - asked).count();
  EXPECT_LT(reached, kLate);
  EXPECT_LT(std::chrono::duration<double>(answered - asked).count(), kLate);
  RecordProperty("emergency_stop_us", static_cast<int>(1e6 * reached));
  const MotionControl::Report ended = report.get();
  EXPECT_TRUE(ended.outcome == Outcome::kStopped || ended.outcome == Outcome::kLost);
  for (std::thread& one : crowd) one.join();
  controller_->block = false;
  EXPECT_TRUE(await([&] { return control_->view().lost.empty(); }));
  expectWords(refusal([&] { home(); }), "emergency stop");
  control_->resetEmergencyStop();
  expectWords(refusal([&] { go({0, 0, 0}); }), "not homed");
}

// Whatever else looks at the state at that moment, a motion says which stop ended it, not the one before.
TEST_F(MotionControlTest, AMotionSaysWhichStopEndedIt) {
  std::atomic<bool> looks{true};
  std::vector<std::thread> crowd;
  for (int i = 0; i < 4; ++i)
    crowd.emplace_back([&] {
      while (looks) control_->view();
    });
  for (int i = 0; i < 20 && !HasFailure(); ++i) {
    home();
    auto report = start({0.010, 0.0, 0.0});
    control_->stop("/first");
    expectWords(report.get().message, "stopped by /first");
    report = start({-0.015, 0.0, 0.0});
    EXPECT_EQ(control_->emergencyStop("/second"), "");
    expectWords(report.get().message, "emergency stop");
    control_->resetEmergencyStop();
  }
  looks = false;
  for (std::thread& one : crowd) one.join();
}

TEST_F(MotionControlTest, NothingBeginsWhileTheAxesMoveOrInAnEmergencyStop) {
  home();
  controller_->set([](AxesState& state) { state.limitSwitch[0] = 1; });
  ASSERT_TRUE(await([&] { return control_->view().state.limitSwitch[0] == 1; }));
  EXPECT_EQ(control_->emergencyStop("/panel"), "");
  expectWords(refusal([&] { control_->moveOffLimit({"test", 0}); }), "emergency stop");
  EXPECT_EQ(control_->view().state.limitSwitch[0], 1) << "it was not moved";
  controller_->set([](AxesState& state) { state.limitSwitch[0] = 0; });
  control_->resetEmergencyStop();
  home();
  controller_->feedHold(true);                                      // else they would be there
  controller_->set([](AxesState& state) { state.moving = true; });  // by hand, at the control's panel
  ASSERT_TRUE(await([&] { return control_->view().state.moving; }));
  for (const auto& begin : std::vector<std::function<void()>>{[&] { home(); },
                                                              [&] {
                                                                go({0.001, 0, 0});
                                                              },
                                                              [&] {
                                                                control_->moveOffLimit({"test", 0});
                                                              }})
    expectWords(refusal(begin), "the axes still move");
}

// Whatever call of the controller it is that does not end.
TEST_F(MotionControlTest, AReadingThatDoesNotEndIsALossThatIsSaid) {
  home();
  auto report = start({0.010, 0.0, 0.0}, 0.0005);
  controller_->blockTemperatures = true;
  std::thread reading([&] { control_->temperatures(); });
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLost);
  expectWords(ended.message, "has not answered");
  EXPECT_GE(controller_->stops, 1);
  controller_->blockTemperatures = false;
  reading.join();
}

TEST_F(MotionControlTest, ABlockedPollIsALossThatIsSaid) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  controller_->block = true;
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLost);
  expectWords(ended.message, "has not answered");
  EXPECT_GE(controller_->stops, 1);
  expectWords(refusal([&] { control_->stop("/panel"); }), "it is unknown whether the axes have stopped");
  expectWords(refusal([&] { home(); }), "only stop and emergency stop are sent to it");
  controller_->block = false;
}

TEST_F(MotionControlTest, ALossIsSaidAndTheConnectionIsMadeAgain) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  controller_->away = true;
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLost);
  expectWords(ended.message, "the cable is out");
  controller_->away = false;
  EXPECT_TRUE(await([&] { return control_->view().lost.empty() && controller_->reconnects > 0; }));
  expectWords(refusal([&] { go({0, 0, 0}); }), "not homed");
}

TEST_F(MotionControlTest, StatesThatCannotBeTrueAreRefused) {
  const std::vector<std::pair<std::function<void(AxesState&)>, std::string>> wrong = {
      {[](AxesState& s) { s.position[1] = std::nan(""); }, "position of y is not a number"},
      {[](AxesState& s) { s.position.resize(5); }, "5 positions for 3 axes"},
      {[](AxesState& s) { s.velocity.resize(1); }, "1 velocities for 3 axes"},
      {[](AxesState& s) { s.time -= 1e6; }, "clock went back"},
      {[](AxesState& s) { s.position[0] += 5e-3; }, "the position of x jumped by 5"}};
  for (const auto& [change, words] : wrong) {
    begin({});
    home();
    auto report = start({0.010, 0.0, 0.0});
    const auto broken = change;
    ending_ = true;  // the loop must not run while what it tells is exchanged
    loop_.join();
    controller_->change = broken;
    ending_ = false;
    loop_ = std::thread([this] {
      while (!ending_) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        control_->cycle(1e-3, std::chrono::duration<double>(Wall::now().time_since_epoch()).count());
      }
    });
    const MotionControl::Report ended = report.get();
    EXPECT_EQ(ended.outcome, Outcome::kLost) << words;
    expectWords(ended.message, words);
    EXPECT_GE(controller_->stops, 1) << words;
    for (const double q : control_->view().state.position) EXPECT_TRUE(std::abs(q) < 0.011) << words;
  }
}

TEST_F(MotionControlTest, AFrozenStateIsALoss) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  controller_->frozen = true;
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLost);
  EXPECT_GE(controller_->stops, 1);
}

TEST_F(MotionControlTest, FeedHoldAndResume) {
  MotionControl::Settings settings;
  settings.holdLimit = 0.2;
  begin(settings);
  home();
  expectWords(refusal([&] { control_->hold(true); }), "nothing moves");
  auto report = start({0.010, 0.0, 0.0}, 0.005);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->hold(false);
  EXPECT_EQ(report.get().outcome, Outcome::kReached);
  auto again = start({0.0, 0.0, 0.0}, 0.002);
  control_->hold(true);
  const MotionControl::Report ended = again.get();
  EXPECT_EQ(ended.outcome, Outcome::kHeld);
  control_->hold(false);
  expectWords(refusal([&] { control_->setOverride(2.0); }), "at most 1");
}

TEST_F(MotionControlTest, AlarmsAreSaidAndCleared) {
  home();
  auto report = start({0.010, 0.0, 0.0});
  controller_->set([](AxesState& state) {
    state.alarm = {1, "hard limit", "move off the limit, clear, home"};
    state.moving = false;
    state.outcome = Outcome::kLimit;
    state.limitSwitch[0] = 1;
    state.velocity.assign(3, 0.0);
  });
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLimit);
  expectWords(ended.message, "alarm 1: hard limit; move off the limit");
  expectWords(refusal([&] { go({0, 0, 0}); }), "alarm 1");
  control_->clearAlarm();
  control_->moveOffLimit({"test", 0});
  EXPECT_EQ(go({0, 0, 0}).outcome, Outcome::kReached);
}

TEST_F(MotionControlTest, HomingInOrder) {
  MotionControl::Settings settings;
  settings.homingOrder = {{"z"}, {"x", "y"}};
  begin(settings);
  home();
  ASSERT_EQ(controller_->homed.size(), 2u);
  EXPECT_EQ(controller_->homed[0], (std::vector<std::size_t>{2}));
  EXPECT_EQ(controller_->homed[1], (std::vector<std::size_t>{0, 1}));
  control_->home({"y"}, {"test", 0});
  EXPECT_EQ(controller_->homed.back(), (std::vector<std::size_t>{1}));
  expectWords(refusal([&] { control_->home({"q"}, {"test", 0}); }), "'q' is not moved");
}

TEST_F(MotionControlTest, CancelSendsStop) {
  home();
  const AxesMotion motion = to({0.010, 0.0, 0.0}, 0.002);
  int calls = 0;
  const MotionControl::Report ended =
      control_->move(motion, {"test", 0}, control_->stops(), [&](const AxesState&) { return ++calls < 10; });
  EXPECT_EQ(ended.outcome, Outcome::kStopped);
  EXPECT_GE(controller_->stops, 1);
  EXPECT_FALSE(control_->view().state.moving);
}

}  // namespace
}  // namespace mm
