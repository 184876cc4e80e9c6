#include "session/plan_ways.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

const std::string kTwoBalls =
    "artifact: {name: two, probe: {tip_radius_mm: 1}, balls: [{name: b0, centre_mm: [-8, 5, -4], radius_mm: "
    "4}, {name: b1, centre_mm: [8, 5, -4], radius_mm: 4}]}\n";

struct Ways {
  Plan plan;
  std::vector<BlockedWay> blocked;
  std::string text;
};

Ways waysOf(const std::string& yaml, const char* name = "three_axis") {
  const Machine machine = Machine::load(name);
  Ways ways{Plan::parse(yaml, "plan.yaml", ".", machine), {}, {}};
  ways.blocked = blockedWays(ways.plan, machine);
  ways.text = blockedWaysText(ways.plan, ways.blocked);
  return ways;
}

const std::string kLeft = "  - {x_mm: -15, y_mm: 5, z_mm: -4, feature: b0}\n";
const std::string kRight = "  - {x_mm: 15, y_mm: 5, z_mm: -4, feature: b1}\n";

TEST(PlanWays, AWayThroughABallIsNamedWithItsTouchAndBall) {
  const Ways ways = waysOf(kTwoBalls + "moves:\n" + kLeft + kRight);
  ASSERT_EQ(ways.blocked.size(), 1u);  // through both: the first in the list stands for the equally deep one
  EXPECT_EQ(ways.blocked[0].move, 1u);
  EXPECT_NEAR(ways.blocked[0].depth, 5e-3, 1e-9);  // through its centre: radius of ball and tip
  EXPECT_EQ(
      ways.text,
      "plan.yaml:4: the way to move 1, a touch of 'b1', leads through ball 'b0', 5 mm deep; on a machine "
      "the probe would collide there: give 'clearance' a joint and a reading at which everything can be "
      "passed, or put moves between");
}

TEST(PlanWays, TheRestIsCounted) {
  const Ways ways = waysOf(kTwoBalls + "moves:\n" + kLeft + kRight + kLeft + kRight);
  EXPECT_EQ(ways.blocked.size(), 3u);
  EXPECT_NE(ways.text.find("and so do 2 more ways through a ball"), std::string::npos) << ways.text;
}

TEST(PlanWays, ClearanceAndMovesBetweenKeepThemFree) {
  EXPECT_EQ(waysOf(kTwoBalls + "clearance: {z_mm: 5}\nmoves:\n" + kLeft + kRight).text, "");
  EXPECT_EQ(waysOf(kTwoBalls + "moves:\n" + kLeft + "  - {z_mm: 5}\n  - {x_mm: 15, y_mm: 5}\n" + kRight).text,
            "");
}

TEST(PlanWays, AClearanceThatIsTooLowDoesNotHelp) {
  EXPECT_NE(waysOf(kTwoBalls + "clearance: {z_mm: -1}\nmoves:\n" + kLeft + kRight).text, "");
}

TEST(PlanWays, AMoveThatOnlyGoesThereCountsToo) {
  const Ways ways = waysOf(kTwoBalls + "moves:\n" + kLeft + "  - {x_mm: 0}\n  - {z_mm: 5}\n");
  ASSERT_EQ(ways.blocked.size(), 1u);
  EXPECT_NE(ways.text.find("plan.yaml:4: the way to move 1 leads through ball 'b0'"), std::string::npos)
      << ways.text;
}

// One ball that is touched at many angles of a spindle: the others are not there then.
TEST(PlanWays, BallsThatOverlapAreNotThereTogether) {
  const std::string one =
      "artifact: {name: one, probe: {tip_radius_mm: 1}, balls: [{name: p0, centre_mm: [-2, 5, -4], "
      "radius_mm: "
      "4}, {name: p1, centre_mm: [2, 5, -4], radius_mm: 4}]}\nmoves:\n";
  EXPECT_EQ(waysOf(one + "  - {x_mm: -2, y_mm: 5, z_mm: 3, feature: p0}\n  - {x_mm: 2, y_mm: 5, z_mm: 3, "
                         "feature: p1}\n")
                .text,
            "");
  EXPECT_NE(waysOf(one + "  - {x_mm: -9, y_mm: 5, z_mm: -4, feature: p0}\n  - {x_mm: 9, y_mm: 5, z_mm: -4, "
                         "feature: p1}\n")
                .text,
            "");
}

// Half a turn of a table carries the tip round its axis: the straight line between both ends says nothing.
TEST(PlanWays, ARotaryJointLeadsTheTipRound) {
  const Machine machine = Machine::load("five_axis");
  int rotary = -1;
  for (int j = 0; j < machine.jointCount(); ++j)
    if (machine.joints()[j].kind == JointKind::kRotary) rotary = j;
  ASSERT_GE(rotary, 0);
  std::vector<double> from(machine.jointCount(), 0.0), middle = from, to = from;
  from[rotary] = -0.8;
  to[rotary] = 0.8;
  Plan plan;
  plan.source = "plan.yaml";
  plan.artifact.tipRadius = 1e-3;
  Feature ball;
  ball.name = "b0";
  ball.radius = 1e-3;
  ball.position = machine.nominal(middle.data(), kNotMeasured).position;
  plan.artifact.features.push_back(ball);
  for (const auto& position : {from, to}) {
    PlanMove move;
    move.position = position;
    plan.moves.push_back(move);
  }
  const Eigen::Vector3d a = machine.nominal(from.data(), kNotMeasured).position,
                        b = machine.nominal(to.data(), kNotMeasured).position;
  ASSERT_GT((0.5 * (a + b) - ball.position).norm(), 3e-3) << "the straight line would meet it, too";
  EXPECT_EQ(blockedWays(plan, machine).size(), 1u);
}

// But for the one that is only simulated, and says so.
TEST(PlanWays, NoShippedPlanLeadsThroughABall) {
  for (const char* name : {"config/plans/nine_ball_plate.yaml", "config/plans/interferometer.yaml",
                           "config/demo_plan.yaml", "test/ros/short_plan.yaml"}) {
    const Machine machine = Machine::load("three_axis");
    const Plan plan = Plan::load(name, machine);
    EXPECT_EQ(blockedWaysText(plan, blockedWays(plan, machine)), "") << name;
  }
}

}  // namespace
}  // namespace mm
