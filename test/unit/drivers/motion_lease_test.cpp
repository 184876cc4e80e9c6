// A motion lives only as long as somebody answers for it.
#include <gtest/gtest.h>

#include "fake_motion_fixture.h"

namespace mm {
namespace {

constexpr double kLease = 0.5;  // s, as the node measure renews

class MotionLeaseTest : public FakeMotionFixture {
 protected:
  /// A slow motion of whoever that is: 10 s to its target.
  std::future<MotionControl::Report> slow(const Mover& mover) {
    const AxesMotion motion = to({0.010, 0.0, 0.0}, 0.001);
    const std::uint32_t stops = control_->stops();
    auto report = std::async(std::launch::async, [=] { return control_->move(motion, mover, stops); });
    EXPECT_TRUE(await([&] { return control_->view().state.moving; }));
    return report;
  }
  std::uint64_t take(double seconds) { return control_->owner().take({"measure", 0}, seconds); }
  void expectStopped(std::future<MotionControl::Report>& report, const std::string& words) {
    ASSERT_EQ(report.wait_for(std::chrono::seconds(4)), std::future_status::ready) << "it moves on";
    const MotionControl::Report ended = report.get();
    EXPECT_EQ(ended.outcome, Outcome::kStopped);
    expectWords(ended.message, words);
    EXPECT_LT(ended.position[0], 0.009);
    EXPECT_GE(controller_->stops, 1);
    EXPECT_FALSE(control_->view().state.moving);
  }
};

TEST_F(MotionLeaseTest, AMotionEndsWhenItsLeaseIsNotRenewed) {
  home();
  const std::uint64_t ticket = take(kLease);
  auto report = slow({"measure", ticket});
  const double began = steadySeconds();
  expectStopped(report, "the lease of 'measure' was not renewed for 0.5 s");
  EXPECT_LT(steadySeconds() - began, kLease + kLate);
  expectWords(refusal([&] {
                control_->owner().take({"measure", ticket}, kLease);
              }),
              "no longer valid: it was not renewed for 0.5 s");
  EXPECT_EQ(go({0.0, 0.0, 0.0}).outcome, Outcome::kReached) << "others may move";
}

TEST_F(MotionLeaseTest, AMotionWhoseLeaseIsRenewedGoesOn) {
  home();
  const std::uint64_t ticket = take(1.0);
  auto report = slow({"measure", ticket});
  for (int i = 0; i < 30; ++i) {  // for longer than the lease
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    control_->owner().take({"measure", ticket}, 1.0);
  }
  EXPECT_TRUE(control_->view().state.moving);
  control_->owner().give(ticket);
  expectStopped(report, "it was given back");
}

TEST_F(MotionLeaseTest, AMotionEndsWithWhoeverAskedForIt) {
  home();
  std::atomic<bool> there{true};
  const Mover panel{"/panel", 0, [&] { return there ? std::string() : std::string("'/panel' has gone"); }};
  auto report = slow(panel);
  there = false;
  expectStopped(report, "'/panel' has gone");
  expectWords(refusal([&] {
                control_->move(to({0.001, 0, 0}), panel, control_->stops());
              }),
              "'/panel' has gone");
}

TEST_F(MotionLeaseTest, HomingEndsWithItToo) {
  std::atomic<bool> there{true};
  const Mover panel{"/panel", 0, [&] { return there ? std::string() : std::string("'/panel' has gone"); }};
  controller_->feedHold(true);  // it does not come to its reference mark
  auto homing = std::async(std::launch::async, [&] { return refusal([&] { control_->home({}, panel); }); });
  ASSERT_TRUE(await([&] { return control_->view().homing && control_->view().state.moving; }));
  there = false;
  expectWords(homing.get(), "homing did not end: '/panel' has gone");
  EXPECT_GE(controller_->stops, 1);
}

TEST_F(MotionLeaseTest, NothingMovesForAReason) {
  home();
  auto report = slow({"panel", 0});
  control_->forbid("the time stands still");
  expectStopped(report, "the time stands still");
  expectWords(refusal([&] { go({0.0, 0.0, 0.0}); }), "the time stands still");
  expectWords(refusal([&] { home(); }), "the time stands still");
  expectWords(control_->view().fault, "the time stands still");
  control_->forbid("");
  EXPECT_EQ(go({0.0, 0.0, 0.0}).outcome, Outcome::kReached);
}

TEST_F(MotionLeaseTest, WhoeverEndsStopsFirst) {
  home();
  auto report = slow({"panel", 0});
  EXPECT_TRUE(control_->shutDown("the driver ends"));
  expectStopped(report, "stopped by the driver ends");
  expectWords(refusal([&] { go({0.0, 0.0, 0.0}); }), "the driver is shutting down");
}

TEST_F(MotionLeaseTest, AStopDuringAResetOfTheEmergencyStopStays) {
  home();
  EXPECT_EQ(control_->emergencyStop("/panel"), "");
  for (const bool emergency : {true, false}) {
    const int before = controller_->emergencies;
    std::thread other;
    controller_->beforeReset = [&] {
      const std::uint32_t stops = control_->stops();
      other = std::thread([&] {
        if (emergency)
          control_->emergencyStop("/other");
        else
          refusal([&] { control_->stop("/other"); });
      });
      EXPECT_TRUE(await([&] { return control_->stops() != stops; }));
    };
    expectWords(refusal([&] { control_->resetEmergencyStop(); }), "stopped again by /other");
    other.join();
    EXPECT_GT(controller_->emergencies, before + (emergency ? 1 : 0)) << "the controller is told once more";
    EXPECT_TRUE(control_->view().state.emergencyStop);
  }
  controller_->beforeReset = nullptr;
  control_->resetEmergencyStop();
  EXPECT_FALSE(control_->view().state.emergencyStop);
}

TEST_F(MotionLeaseTest, AMotionThatNobodyWatchedForLongIsEnded) {
  home();
  auto report = slow({"test", 0});
  control_->paused(0.9);  // as long as a controller may be silent
  EXPECT_EQ(report.wait_for(std::chrono::milliseconds(200)), std::future_status::timeout) << "goes on";
  control_->paused(1.1);
  ASSERT_EQ(report.wait_for(std::chrono::seconds(4)), std::future_status::ready) << "it moves on";
  const MotionControl::Report ended = report.get();
  EXPECT_EQ(ended.outcome, Outcome::kLost);
  expectWords(ended.message, "the driver was suspended for 1.1 s, during which the motion was not monitored");
  EXPECT_FALSE(control_->view().state.moving);
}

}  // namespace
}  // namespace mm
