#include "drivers/linuxcnc_controller.h"

#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <sstream>

#include "base/error.h"
#include "motion_fixture.h"

namespace mm {
namespace {

/// LinuxCNC's double, behind the real helpers, with X Y Z A B and a ball at x 20, y 30, z 10 mm.
class LinuxCncTest : public DeviceMotionFixture {
 protected:
  LinuxCncTest() : DeviceMotionFixture("test/ros/linuxcnc/machine.urdf") {}
  void SetUp() override {
    double_ = std::make_unique<DeviceDouble>(
        std::vector<std::string>{"test/doubles/linuxcnc_double.py", "--ball", "20", "30", "10", "5"});
    speakWith(*double_);
    connect();
  }
  /// The helpers' module LinuxCNC is the double.
  static void speakWith(const DeviceDouble& one) {
    const std::string address = one.address();
    ::setenv("MM_LINUXCNC_DOUBLE", address.substr(address.rfind(':') + 1).c_str(), 1);
    ::setenv("PYTHONPATH", "test/doubles/linuxcnc_module", 1);
  }
  /// The helpers' processes: of the role that states tell, or of that which gives commands.
  static std::vector<pid_t> helpers(const std::string& role) {
    std::vector<pid_t> found;
    for (const auto& process : std::filesystem::directory_iterator("/proc")) {
      std::ifstream file(process.path() / "cmdline"), stat(process.path() / "stat");
      std::string command{std::istreambuf_iterator<char>(file), {}}, number, name, state, parent;
      stat >> number >> name >> state >> parent;
      const std::string words = std::string("linuxcnc_helper") + '\0' + role;
      if (command.find(words) != std::string::npos && parent == std::to_string(::getpid()))
        found.push_back(std::stoi(number));
    }
    return found;
  }
  void connect() {
    control(std::make_shared<LinuxCncController>(), {{"coordinates", "XYZAB"},
                                                     {"poll_rate", "100"},
                                                     {"connect_timeout", std::to_string(kConnect)},
                                                     {"dead_man", std::to_string(linkSilence_)},
                                                     {"silence", std::to_string(linkSilence_)}});
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
  LinuxCncFaultsTest() { watchAsTheDriver(); }
};

TEST_F(LinuxCncTest, HomesGoesProbesStops) {
  expectWords(refusal([&] { control_->home({}, {"test", 0}); }), "emergency stop");
  readyAt({20, 30, 17});
  MotionControl::Report report = go({20, 30, 14}, 3e-3, true);
  ASSERT_EQ(report.outcome, Outcome::kTripped) << report.message;
  ASSERT_TRUE(await([&] {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !trips_.empty();
  }));
  EXPECT_TRUE(trips_[0].probing && trips_[0].actual);
  EXPECT_NEAR(trips_[0].position[2], 16e-3, 5e-6) << "work offsets taken off";
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

TEST_F(LinuxCncTest, AStopThatHasNoEffectIsSaidAgain) {
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
  // For ever without effect: said.
  control_->resetEmergencyStop();
  ASSERT_TRUE(await([&] { return !control_->view().state.emergencyStop; }));
  double_->tell("refuse 1000");
  control_->emergencyStop("/panel");
  EXPECT_TRUE(await([&] {
    return control_->view().lost.find("press the machine's emergency stop button") != std::string::npos;
  })) << control_->view().lost;
}

TEST_F(LinuxCncTest, AStopOfWhichIsHeardLateThatItWasTakenIsOverThen) {
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4}, 0.01);
  double_->tell("slow 0.4");
  EXPECT_EQ(refusal([&] { control_->stop("/panel"); }), "");
  EXPECT_EQ(moving.get().outcome, Outcome::kStopped);
  double_->tell("slow 0");
  EXPECT_EQ(arrive({-90, 0, 4}).outcome, Outcome::kReached);
}

// Whichever helper cannot: the other one stops what moves.
TEST_F(LinuxCncTest, AHelperThatHangsOrIsKilledKeepsNoStopBack) {
  for (const int signal : {SIGSTOP, SIGKILL}) {
    for (const char* role : {"watch", "act"}) {
      readyAt({0, 0, 4});
      auto moving = start({-90, 0, 4}, 0.01);
      const std::vector<pid_t> pids = helpers(role);
      ASSERT_EQ(pids.size(), 1u) << role;
      ASSERT_EQ(::kill(pids[0], signal), 0);
      const double asked = steadySeconds();
      auto stopped =
          std::async(std::launch::async, [&] { return refusal([&] { control_->stop("/panel"); }); });
      EXPECT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); }, kLate))
          << role << signal;
      std::printf("stop with '%s' %s: at rest after %.0f ms\n", role,
                  signal == SIGSTOP ? "stopped" : "killed", 1e3 * (steadySeconds() - asked));
      EXPECT_GT(double_->tell("machine")["position"][0].get<double>(), -85.0);
      if (signal == SIGSTOP) ::kill(pids[0], SIGCONT);
      stopped.get();
      EXPECT_NE(moving.get().outcome, Outcome::kReached);
    }
  }
}

/// Without a driver's cycle: nobody says that it lives.
class LinuxCncDeadManTest : public LinuxCncTest {
 protected:
  void stopCycling() {
    ending_ = true;
    loop_.join();
    loop_ = std::thread([] {});
  }
};

TEST_F(LinuxCncDeadManTest, ADriverThatGivesNoSignIsStoppedAndSaysSo) {
  linkSilence_ = 0.5;
  TearDown();
  ending_ = false;
  connect();
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4}, 0.01);
  const double from = double_->tell("machine")["position"][0];
  stopCycling();
  EXPECT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); }, 2.0));
  EXPECT_GT(double_->tell("machine")["position"][0].get<double>(), from - 20.0);
  ending_ = false;
  loop_.join();
  cycle();
  const MotionControl::Report report = moving.get();
  EXPECT_EQ(report.outcome, Outcome::kStopped);
  expectWords(report.message, "the driver's heartbeat was missing");
}

// The end of the driver's process is the end of the pipe.
TEST_F(LinuxCncDeadManTest, ADriverThatIsKilledLeavesNothingMoving) {
  readyAt({0, 0, 4});
  TearDown();
  const pid_t driver = ::fork();
  if (driver == 0) {
    LinuxCncController one;
    one.open(controllerSetup(machine_, {{"coordinates", "XYZAB"}}));
    AxesState state = one.poll(0.0);
    AxesMotion motion = straightMotion(machine_.joints(), state.position, {-90e-3, 0, 4e-3, 0, 0}, 0.01, 0.7);
    motion.id = 1;
    one.move(motion);
    for (;;) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      one.poll(0.01);
    }
  }
  ASSERT_TRUE(await([&] { return double_->tell("machine")["moving"].get<bool>(); }, 10.0));
  ::kill(driver, SIGKILL);
  ::waitpid(driver, nullptr, 0);
  const double from = steadySeconds();
  EXPECT_TRUE(await([&] { return !double_->tell("machine")["moving"].get<bool>(); }, 2.0));
  std::printf("driver killed: at rest after %.0f ms\n", 1e3 * (steadySeconds() - from));
}

// A workpiece that was aligned leaves work coordinates that are turned, in which alone G38 is told where to
// go.
TEST_F(LinuxCncTest, ProbingGoesAlongTheMachinesAxesWhereTheWorkCoordinatesAreTurned) {
  readyAt({20, 30, 17});
  for (const char* turn : {"mdi G10 L2 P1 X0 Y0 Z0 R90", "mdi G10 L2 P1 X7 Y-3 Z2 R30"}) {
    EXPECT_EQ(go({40, 30, 7}).outcome, Outcome::kReached);
    double_->tell(turn);
    trips_.clear();
    MotionControl::Report report = go({20, 30, 7}, 5e-3, true);
    ASSERT_EQ(report.outcome, Outcome::kTripped) << turn << ": " << report.message;
    const auto at = double_->tell("machine")["position"];
    EXPECT_NEAR(at[1].get<double>(), 30.0, 1e-3) << turn;
    EXPECT_NEAR(at[2].get<double>(), 7.0, 1e-3) << turn;
    ASSERT_TRUE(await([&] {
      const std::lock_guard<std::mutex> lock(mutex_);
      return !trips_.empty();
    }));
    // the ball's radius and the tip's are 6 mm, 3 mm above its centre's height
    EXPECT_NEAR(trips_[0].position[0], 1e-3 * (20.0 + std::sqrt(36.0 - 9.0)), 2e-5) << turn;
    EXPECT_NEAR(trips_[0].position[1], 30e-3, 1e-6) << turn;
    EXPECT_NEAR(trips_[0].position[2], 7e-3, 1e-6) << turn;
    EXPECT_EQ(go({40, 30, 7}).outcome, Outcome::kReached);
    report = go({40, 40, 8}, 0.02, true);
    EXPECT_EQ(report.outcome, Outcome::kReached) << turn << ": " << report.message;
  }
}

// What it says of its axes is in the units of its .ini.
TEST_F(LinuxCncTest, AMachineInInchesIsRefused) {
  DeviceDouble inches({"test/doubles/linuxcnc_double.py"});
  inches.tell("units 0.0393700787");
  speakWith(inches);
  LinuxCncController controller;
  expectWords(refusal([&] {
                controller.open(controllerSetup(machine_, {{"coordinates", "XYZAB"}}));
              }),
              "LINEAR_UNITS");
}

TEST_F(LinuxCncTest, AHelperThatIsNotThereIsNamed) {
  LinuxCncController controller;
  expectWords(refusal([&] {
                controller.open(controllerSetup(machine_, {{"helper", "/nowhere"}}));
              }),
              "/nowhere");
}

TEST_F(LinuxCncTest, AHelperThatSpeaksAnotherLanguageIsNamed) {
  LinuxCncController controller;
  expectWords(refusal([&] {
                controller.open(controllerSetup(machine_, {{"helper", "/bin/echo"}}));
              }),
              "not from linuxcnc_helper");
}

TEST_F(LinuxCncFaultsTest, WhereNoLinuxCncRunsThatIsSaid) {
  double_->tell("fault off");
  ASSERT_TRUE(await([&] { return !control_->view().lost.empty(); }));
  double_->tell("fault ok");
  ASSERT_TRUE(await([&] { return control_->view().lost.empty(); }, 10.0)) << control_->view().lost;
}

TEST_F(LinuxCncTest, AnOverrideDuringFeedHoldIsGivenAtItsEnd) {
  readyAt({0, 0, 4});
  auto held = start({-30, 0, 4}, 0.02);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->setOverride(0.5);
  control_->hold(false);
  EXPECT_EQ(held.get().outcome, Outcome::kReached);
  std::vector<double> told;
  const auto machine = double_->tell("machine");
  for (const auto& one : machine["told"])
    if (one[0] == "override") told.push_back(one[1]);
  EXPECT_EQ(told, (std::vector<double>{0.0, 50.0})) << "once, when the hold ended";
}

TEST_F(LinuxCncTest, AStopEndsAFeedHoldAndNothingMovesFor) {
  readyAt({0, 0, 4});
  auto held = start({-90, 0, 4}, 0.02);
  control_->setOverride(0.8);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  const double where = shown(0);
  control_->stop("/panel");
  EXPECT_EQ(held.get().outcome, Outcome::kStopped);
  EXPECT_TRUE(await([&] { return control_->view().state.feedOverride == 0.8; }))
      << control_->view().state.feedOverride;
  EXPECT_EQ(shown(0), where);
  EXPECT_FALSE(control_->view().state.held);
  EXPECT_EQ(go({0, 0, 4}).outcome, Outcome::kReached);
}

TEST_F(LinuxCncTest, AnEmergencyStopEndsAFeedHold) {
  readyAt({0, 0, 4});
  auto held = start({-90, 0, 4}, 0.02);
  control_->hold(true);
  ASSERT_TRUE(await([&] { return control_->view().state.held; }));
  control_->emergencyStop("/panel");
  EXPECT_EQ(held.get().outcome, Outcome::kStopped);
  control_->resetEmergencyStop();
  EXPECT_TRUE(await([&] { return control_->view().state.feedOverride == 1.0; }));
  readyAt({0, 0, 4});
}

// One that was left by a driver that ended.
TEST_F(LinuxCncTest, AFeedHoldThatIsFoundIsEnded) {
  readyAt({0, 0, 4});
  TearDown();
  double_->tell("override 0");
  ending_ = false;
  connect();
  readyAt({10, 0, 4});
  EXPECT_EQ(control_->view().state.feedOverride, 1.0);
}

TEST_F(LinuxCncTest, AnOverrideThatIsAskedForWhileThePanelStandsAtZeroCountsFromWhenItDoesNot) {
  readyAt({0, 0, 4});
  double_->tell("override 0");
  ASSERT_TRUE(await([&] { return control_->view().state.feedOverride == 0.0; }));
  control_->setOverride(0.5);
  EXPECT_EQ(double_->tell("state")["override"], 0.0) << "what the panel holds is not let go";
  double_->tell("override 100");
  EXPECT_TRUE(await([&] { return control_->view().state.feedOverride == 0.5; }))
      << control_->view().state.feedOverride;
}

// The speed limits of the URDF hold for the whole; before, a motion ran at 1.2 times its speed.
TEST_F(LinuxCncTest, AnOverrideAboveTheWholeIsTakenBack) {
  readyAt({0, 0, 4});
  auto moving = start({-60, 0, 4}, 0.02);
  double_->tell("override 120");
  EXPECT_TRUE(await([&] { return double_->tell("state")["override"] == 1.0; }));
  EXPECT_EQ(moving.get().outcome, Outcome::kReached);
  control_->setOverride(0.5);
  ASSERT_TRUE(await([&] { return control_->view().state.feedOverride == 0.5; }));
  double_->tell("override 120");
  EXPECT_TRUE(await([&] { return double_->tell("state")["override"] == 0.5; }));
}

TEST_F(LinuxCncTest, AnOverrideIsGivenWhileTheMachineIsOff) {
  readyAt({0, 0, 4});
  double_->tell("fault_joint 1");
  ASSERT_TRUE(await([&] { return control_->view().state.alarm.present(); }));
  control_->setOverride(0.5);
  EXPECT_TRUE(await([&] { return double_->tell("state")["override"] == 0.5; }));
  double_->tell("override 120");
  EXPECT_TRUE(await([&] { return double_->tell("state")["override"] == 0.5; }));
  ASSERT_EQ(refusal([&] { control_->clearAlarm(); }), "");
}

// LinuxCNC switches its machine off, and takes nothing but switching it on until the switch is open.
TEST_F(LinuxCncTest, ALimitSwitchIsNamedAndTheWayOutLeadsOut) {
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4}, 0.02);
  double_->tell("limit 0 -1");
  MotionControl::Report report = moving.get();
  EXPECT_EQ(report.outcome, Outcome::kLimit) << report.message;
  expectWords(report.message, "joint 0 on limit switch error");
  ASSERT_TRUE(await([&] { return control_->view().state.alarm.present(); }));
  expectWords(control_->view().fault, "x is at its lower limit switch");
  EXPECT_EQ(refusal([&] { control_->stop("/panel"); }), "") << "nothing moves that it refuses to end";
  const std::string closed = refusal([&] { control_->clearAlarm(); });
  expectWords(closed, "x is at its lower limit switch");
  EXPECT_EQ(closed.find("call ~clear_alarm to switch it on"), std::string::npos) << closed;
  double_->tell("limit 0 0");
  EXPECT_TRUE(await([&] { return refusal([&] { control_->clearAlarm(); }).empty(); }));
  EXPECT_TRUE(control_->view().state.homed);
  EXPECT_FALSE(await([&] { return control_->view().state.moving; }, 0.3)) << "it is busy with being on";
  report = go({0, 0, 4});
  EXPECT_EQ(report.outcome, Outcome::kReached) << report.message;
}

TEST_F(LinuxCncTest, AFaultThatSwitchesItOffIsSaidInItsWords) {
  readyAt({0, 0, 4});
  auto moving = start({-90, 0, 4}, 0.02);
  double_->tell("fault_joint 1");
  const MotionControl::Report report = moving.get();
  EXPECT_EQ(report.outcome, Outcome::kAlarm);
  expectWords(report.message, "joint 1 following error");
  ASSERT_TRUE(await([&] { return control_->view().state.alarm.present(); }));
  expectWords(control_->view().fault, "joint 1 following error");
  ASSERT_FALSE(await([&] { return !control_->view().state.alarm.present(); }, 0.4)) << "it stays off";
  double_->tell("say a command was refused");
  EXPECT_FALSE(await([&] { return control_->view().fault.find("refused") != std::string::npos; }, 0.3))
      << "what is said later is not why it went off: " << control_->view().fault;
  EXPECT_EQ(refusal([&] { control_->clearAlarm(); }), "");
}

TEST_F(LinuxCncTest, AxesThatSomebodyElseMovesAreSeenAndNoMotionIsQueuedBehind) {
  readyAt({0, 0, 4});
  double_->tell("mdi G21 G90 G53 G1 X60 F900");
  ASSERT_TRUE(await([&] { return control_->view().state.moving; }));
  EXPECT_TRUE(await([&] { return std::abs(control_->view().state.velocity[0] - 15e-3) < 3e-3; }));
  expectWords(refusal([&] { go({0, 20, 4}); }), "the axes still move");
  EXPECT_LE(double_->tell("state")["queue"].get<int>(), 0);
  control_->stop("/panel");
  EXPECT_FALSE(double_->tell("machine")["moving"]);
  EXPECT_LT(shown(0), 59.0);
  EXPECT_TRUE(await([&] { return !control_->view().state.moving; }));
  EXPECT_EQ(control_->view().state.velocity[0], 0.0);
  EXPECT_EQ(go({0, 0, 4}).outcome, Outcome::kReached);
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

TEST_F(LinuxCncFaultsTest, EveryFaultOfLinuxCncIsSaidAndTheEmergencyStopComesThrough) {
  const std::vector<std::pair<std::string, std::string>> faults = {{"off", "ended"},
                                                                   {"stuck", "has given no state"},
                                                                   {"wrong", "the position of x jumped by"},
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
