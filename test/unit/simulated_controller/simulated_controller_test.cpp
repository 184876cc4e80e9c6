#include "simulated_controller/simulated_controller.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"

namespace mm {
namespace {

constexpr double kTick = 1e-3;  // s

Machine machine() { return Machine::load("three_axis"); }

class SimulatedControllerTest : public ::testing::Test {
 protected:
  void open(AxisController::Parameters parameters = {}) {
    parameters.emplace("plan", "config/plans/nine_ball_plate.yaml");
    controller_.open(controllerSetup(machine_, parameters));
    state_ = controller_.poll(0.0);
  }
  void run(double seconds) {
    for (double t = 0.0; t < seconds; t += kTick) state_ = controller_.poll(kTick);
  }
  void homeAxes() {
    controller_.home({0, 1, 2});
    run(3.0);
    ASSERT_TRUE(state_.homed);
  }
  void go(const std::vector<double>& target, bool probing = false) {
    AxesMotion motion =
        straightMotion(machine_.joints(), state_.position, target, probing ? 2e-3 : 20e-3, 1.0);
    motion.probing = probing;
    controller_.move(motion);
    for (int i = 0; i < 20000; ++i) {
      state_ = controller_.poll(kTick);
      if (!state_.moving) return;
    }
    FAIL() << "never arrived";
  }

  Machine machine_ = machine();
  SimulatedController controller_;
  AxesState state_;
};

TEST_F(SimulatedControllerTest, NoMotionBeforeHoming) {
  open();
  EXPECT_FALSE(state_.homed);
  EXPECT_THROW(controller_.move(straightMotion(machine_.joints(), state_.position, {0, 0, 0}, 0.01, 1.0)),
               Error);
  homeAxes();
  for (const double q : state_.position) EXPECT_EQ(q, 0.0);
  EXPECT_FALSE(state_.moving);
}

TEST_F(SimulatedControllerTest, AxesArriveTogetherAtTheSpeedAsked) {
  open();
  homeAxes();
  controller_.move(straightMotion(machine_.joints(), state_.position, {0.010, 0.005, 0.0}, 0.010, 1.0));
  run(0.5);
  EXPECT_NEAR(state_.position[0], 0.005 - 1e-4, 2e-5) << "10 mm/s after 20 ms of acceleration";
  EXPECT_NEAR(state_.position[1], 0.0025 - 0.5e-4, 1e-5);
  EXPECT_NEAR(state_.velocity[0], 0.010, 1e-9);
  EXPECT_TRUE(state_.moving);
  run(0.6);
  EXPECT_FALSE(state_.moving);
  EXPECT_EQ(state_.position[0], 0.010);
  EXPECT_EQ(state_.velocity[0], 0.0);
}

TEST_F(SimulatedControllerTest, StopStopsAndEmergencyStopNeedsHoming) {
  open();
  homeAxes();
  controller_.move(straightMotion(machine_.joints(), state_.position, {0.010, 0.0, 0.0}, 0.010, 1.0));
  run(0.2);
  controller_.stop();
  const double there = state_.position[0];
  run(0.2);
  EXPECT_FALSE(state_.moving);
  EXPECT_EQ(state_.outcome, Outcome::kStopped);
  EXPECT_NEAR(state_.position[0] - there, 1e-4, 3e-5) << "from 10 mm/s with 0.5 m/s^2";
  controller_.emergencyStop();
  run(0.01);
  EXPECT_TRUE(state_.emergencyStop);
  EXPECT_FALSE(state_.homed);
  EXPECT_THROW(controller_.home({0, 1, 2}), Error);
  controller_.resetEmergencyStop();
  EXPECT_THROW(controller_.move(straightMotion(machine_.joints(), state_.position, {0, 0, 0}, 0.01, 1.0)),
               Error);
  homeAxes();
}

TEST_F(SimulatedControllerTest, ProbingLatchesTheTripAndStops) {
  open({{"bounce_s", "0.001"}});
  homeAxes();
  go({0.0, 0.0, 0.014});
  go({0.0, -0.008, 0.014});
  // Ball b1: centre (0, -8, -2) mm, radius 3.9685 mm, tip 1 mm: from above at z = 2.9685 mm.
  go({0.0, -0.008, 0.005});
  EXPECT_TRUE(controller_.takeProbeEdges().empty());
  go({0.0, -0.008, -0.001}, true);
  const std::vector<ProbeEdge> edges = controller_.takeProbeEdges();
  ASSERT_EQ(edges.size(), 3u) << "closes, bounces";
  EXPECT_TRUE(edges[0].closed && edges[0].probing);
  EXPECT_NEAR(edges[0].position[2], 2.9685e-3, 0.2e-3) << "the plate lies within 0.05 mm and 0.03 deg";
  EXPECT_NEAR(edges[0].velocity[2], -2e-3, 1e-6);
  EXPECT_LT(edges[0].position[2] - state_.position[2], 30e-6) << "stops within a step of 1 ms, at 2 mm/s";
  EXPECT_TRUE(state_.probeClosed);
  go({0.0, -0.008, 0.005});
  EXPECT_FALSE(state_.probeClosed);
  const std::vector<ProbeEdge> opened = controller_.takeProbeEdges();
  ASSERT_EQ(opened.size(), 1u);
  EXPECT_FALSE(opened[0].closed);
}

TEST_F(SimulatedControllerTest, FaultsOfTheProbe) {
  open({{"fault", "probe_dead"}});
  homeAxes();
  go({0.0, 0.0, 0.014});
  go({0.0, -0.008, 0.014});
  go({0.0, -0.008, -0.001}, true);
  EXPECT_TRUE(controller_.takeProbeEdges().empty());
  EXPECT_FALSE(state_.probeClosed);
  SimulatedController stuck;
  stuck.open(controllerSetup(machine_, {{"fault", "probe_stuck"}}));
  EXPECT_TRUE(stuck.poll(kTick).probeClosed);
}

TEST_F(SimulatedControllerTest, TemperaturesFrozenOrLost) {
  open({{"fault", "temperature_frozen"}});
  const auto first = controller_.temperatures();
  run(1.0);
  EXPECT_EQ(first, controller_.temperatures());
  SimulatedController lost;
  lost.open(controllerSetup(machine_, {{"fault", "temperature_lost"}}));
  EXPECT_TRUE(std::isnan(lost.temperatures().at(0).second));
  EXPECT_FALSE(std::isnan(lost.temperatures().at(1).second));
}

TEST_F(SimulatedControllerTest, HoldOverrideAndHomingByAxis) {
  open();
  controller_.home({2});
  run(1.0);
  EXPECT_EQ(state_.axisHomed, (std::vector<bool>{false, false, true}));
  EXPECT_FALSE(state_.homed);
  homeAxes();
  controller_.setOverride(0.5);
  controller_.move(straightMotion(machine_.joints(), state_.position, {0.010, 0.0, 0.0}, 0.010, 1.0));
  run(0.3);
  EXPECT_NEAR(state_.velocity[0], 0.005, 1e-9);
  controller_.feedHold(true);
  run(0.1);
  EXPECT_TRUE(state_.held);
  const double there = state_.position[0];
  run(0.1);
  EXPECT_EQ(state_.position[0], there);
  controller_.feedHold(false);
  run(3.0);
  EXPECT_EQ(state_.outcome, Outcome::kReached);
  EXPECT_EQ(state_.position[0], 0.010);
}

TEST_F(SimulatedControllerTest, BreaksAsItIsTold) {
  open();
  homeAxes();
  const AxesState good = state_;
  controller_.breakDevice("stuck");
  EXPECT_EQ(controller_.poll(kTick).time, good.time);
  controller_.breakDevice("garbage");
  EXPECT_NE(controller_.poll(kTick).position, good.position);
  controller_.breakDevice("wrong");
  EXPECT_NEAR(controller_.poll(kTick).position[0], 5e-3, 1e-9);
  controller_.breakDevice("slow");
  run(1.0);
  controller_.breakDevice("ok");
  EXPECT_NEAR(controller_.poll(kTick).time - state_.time, 0.3, 2e-3);
  controller_.breakDevice("intermittent");
  int answered = 0, silent = 0;
  for (int i = 0; i < 800; ++i) {
    try {
      controller_.poll(kTick);
      ++answered;
    } catch (const std::exception&) {
      ++silent;
    }
  }
  EXPECT_NEAR(answered, 400, 2);
  EXPECT_NEAR(silent, 400, 2);
  controller_.breakDevice("off");
  EXPECT_THROW(controller_.poll(kTick), std::exception);
  EXPECT_THROW(controller_.reconnect(), std::exception);
  controller_.breakDevice("ok");
  controller_.reconnect();
  const AxesState after = controller_.poll(kTick);
  EXPECT_FALSE(after.homed);
  EXPECT_EQ(after.resets, good.resets + 1);
  EXPECT_THROW(controller_.breakDevice("asleep"), InputError);
}

TEST_F(SimulatedControllerTest, SaysWhichErrorsTheInstrumentHas) {
  open({{"plan", "config/demo_plan.yaml"}, {"hide", "scale:z=0.001; random"}});
  const std::vector<std::string> notes = controller_.capabilities().notes;
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_EQ(
      notes[0],
      "simulated errors: of the plan {type: scale, axis: x}, {type: scale, axis: y}, {type: scale, axis: z}, "
      "{type: squareness, axis: x, of: y}, {type: backlash, axis: x}; of `hide` scale:z=0.001; random");
}

TEST(SimulatedController, UnknownParametersAreNamed) {
  SimulatedController controller;
  try {
    controller.open(controllerSetup(machine(), {{"sede", "1"}}));
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("sede"), std::string::npos) << e.what();
  }
}

TEST(CheckTarget, NamesJointValueAndLimit) {
  const Machine m = machine();
  checkTarget(m.joints(), {0.020, 0.035, -0.020});
  const std::vector<std::pair<std::vector<double>, std::string>> bad = {
      {{0.0201, 0.0, 0.0}, "joint x: target 20.1 mm"},
      {{0.0, 0.0, std::nan("")}, "joint z is not a number"},
      {{0.0, 0.0}, "2 values for 3 joints"}};
  for (const auto& [target, words] : bad) {
    try {
      checkTarget(m.joints(), target);
      FAIL() << words;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(words), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(straightMotion(m.joints(), {0, 0, 0}, {1e-3, 0, 0}, 0.0, 1.0), InputError);
}

}  // namespace
}  // namespace mm
