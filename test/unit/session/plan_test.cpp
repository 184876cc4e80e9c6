#include "session/plan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "base/error.h"
#include "plan_written_out.h"

namespace mm {
namespace {

const std::string kBall =
    "artifact: {name: one, probe: {tip_radius_mm: 1}, balls: [{name: b0, centre_mm: [0, 5, -4], radius_mm: "
    "4}]}\n";

Plan parse(const std::string& yaml, const char* machine = "three_axis") {
  return Plan::parse(yaml, "plan.yaml", ".", Machine::load(machine));
}

void expectRefusal(const std::string& yaml, const std::string& part, const char* machine = "three_axis") {
  try {
    parse(yaml, machine);
    ADD_FAILURE() << "accepted: " << yaml;
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
  }
}

TEST(Plan, EveryShippedPlanIsReadAndCanBeMoved) {
  const std::vector<std::tuple<std::string, std::string, int>> plans = {
      {"nine_ball_plate", "three_axis", 675},
      {"micro_machine_tool", "three_axis", 16310},
      {"interferometer", "three_axis", 350},
      {"five_axis_ball", "five_axis", 360}};
  for (const auto& [name, machineName, count] : plans) {
    const Machine machine = Machine::load(machineName);
    const Plan plan = Plan::load("config/plans/" + name + ".yaml", machine);
    EXPECT_EQ(plan.measurements(), count) << name;
    for (const PlanMove& move : plan.moves)
      for (int j = 0; j < machine.jointCount(); ++j) {
        ASSERT_GE(move.position[j], machine.joints()[j].lower - 1e-9);
        ASSERT_LE(move.position[j], machine.joints()[j].upper + 1e-9);
      }
  }
}

TEST(Plan, MoreMovesThanAnybodyMakesAreRefusedBeforeTheyTakeTheMemory) {
  expectRefusal(kBall + "touch: {points: 10000000, repeats: 10000000}",
                "touch: makes more than 300000 moves; ask for fewer points, repeats or runs");
  expectRefusal("reference: {joint: x, from_mm: -10, to_mm: 10, points: 11, runs: 10000000}",
                "more than 300000 moves");
}

TEST(Plan, ThePlateCatchesEveryAxisInBothDirectionsOfTravel) {
  const Plan plan = Plan::load("config/plans/nine_ball_plate.yaml", Machine::load("three_axis"));
  int counts[3][2] = {};
  for (const PlanMove& move : plan.moves)
    if (move.kind == MoveKind::kTouch)
      for (int j = 0; j < 3; ++j) counts[j][move.target[j] > move.position[j] ? 1 : 0]++;
  for (const auto& axis : counts)
    for (const int count : axis) EXPECT_GT(count, 100);
}

TEST(Plan, ATouchGoesFromItsStartThroughTheSurface) {
  const Plan plan = parse(kBall + "moves: [{x_mm: 0, y_mm: 5, z_mm: 3, feature: b0, speed_mm_s: 1}]");
  ASSERT_EQ(plan.moves.size(), 1u);
  EXPECT_EQ(plan.moves[0].kind, MoveKind::kTouch);
  EXPECT_NEAR(plan.moves[0].position[2], 3e-3, 1e-12);  // the contact is at z = 1 mm
  EXPECT_NEAR(plan.moves[0].target[2], 0.0, 1e-12);     // one millimetre beyond
  EXPECT_NEAR(plan.moves[0].speed, 1e-3, 1e-15);
}

TEST(Plan, AStartAtTheContactIsDrawnBack) {
  const Plan plan = parse(kBall + "moves: [{x_mm: 5, y_mm: 5, z_mm: -4, feature: b0, approach: [-1, 0, 0]}]");
  EXPECT_NEAR(plan.moves[0].position[0], 6.5e-3, 1e-12);
  EXPECT_NEAR(plan.moves[0].target[0], 4e-3, 1e-12);
}

TEST(Plan, FromReachesThePositionFromItsSide) {
  const Plan plan = parse(
      "moves: [{x_mm: 3, from: {x: -1}, reference: x, setup: a}, {x_mm: 3, from: {x: 1}, reference: "
      "position}]");
  ASSERT_EQ(plan.moves.size(), 4u);
  EXPECT_NEAR(plan.moves[0].position[0], 2.8e-3, 1e-12);
  EXPECT_NEAR(plan.moves[2].position[0], 3.2e-3, 1e-12);
  EXPECT_EQ(plan.moves[1].kind, MoveKind::kDeviation);
  EXPECT_EQ(plan.moves[1].joint, 0);
  EXPECT_EQ(plan.moves[1].setup, "a");
  EXPECT_EQ(plan.moves[3].kind, MoveKind::kPosition);
}

TEST(Plan, ReferenceRunsGoUpAndDown) {
  const Plan plan = parse("reference: {joint: y, positions_mm: [0, 10, 20], runs: 2, dwell_s: 1}");
  std::vector<double> measured;
  for (const PlanMove& move : plan.moves)
    if (move.kind == MoveKind::kDeviation) measured.push_back(std::round(move.position[1] * 1e3));
  EXPECT_EQ(measured, (std::vector<double>{0, 10, 20, 20, 10, 0, 0, 10, 20, 20, 10, 0}));
}

TEST(Plan, AGroupOfMovesIsMadeAgain) {
  const Plan plan = parse(
      "moves: [{x_mm: 1}, {repeats: 4, moves: [{x_mm: 2}, {repeats: 3, moves: [{y_mm: 3, reference: "
      "position}]}]}]");
  ASSERT_EQ(plan.moves.size(), 1u + 4 * (1 + 3));
  EXPECT_EQ(plan.measurements(), 4 * 3);
  EXPECT_NEAR(plan.moves[1].position[1], 0.0, 1e-12);  // the first time y is where it was
  for (std::size_t i = 5; i < plan.moves.size(); ++i) {
    EXPECT_NEAR(plan.moves[i].position[0], 2e-3, 1e-12);
    EXPECT_NEAR(plan.moves[i].position[1], 3e-3, 1e-12);
    EXPECT_EQ(plan.moves[i].kind, i % 4 == 1 ? MoveKind::kGo : MoveKind::kPosition);
  }
  expectRefusal("moves: [{repeats: 0, moves: [{x_mm: 1, reference: x}]}]", "at least 1");
  expectRefusal("moves: [{repeats: 3, moves: []}]", "must be a list of one or more");
  expectRefusal("moves: [{repeats: 3, x_mm: 1}]", "unknown key 'repeats'");
  expectRefusal("moves: [{repeats: 1000, moves: [{repeats: 1000, moves: [{x_mm: 1, reference: x}]}]}]",
                "more than 300000 moves");
  std::string deep = "{x_mm: 1, reference: x}";
  for (int i = 0; i < 8; ++i) deep = "{moves: [" + deep + "]}";
  expectRefusal("moves: [" + deep + "]", "more than 8 deep");
}

TEST(Plan, ALengthBeginsAtAPoint) {
  const std::string beam =
      "artifact: {name: beam, points: [{name: p, position_mm: [-100, 0, 0]}], balls: [{name: b, centre_mm: "
      "[0, 0, -9], radius_mm: 4}]}\n";
  const Plan plan =
      parse(beam + "moves: [{x_mm: 3, from: {x: -1}, reference: length, feature: p, setup: s}]");
  ASSERT_EQ(plan.moves.size(), 2u);
  EXPECT_EQ(plan.moves[1].kind, MoveKind::kLength);
  EXPECT_EQ(plan.moves[1].feature, plan.artifact.findFeature("p"));
  EXPECT_EQ(plan.moves[1].setup, "s");
  const Machine machine = Machine::load("three_axis");
  const Plan again = Plan::parse(planYaml(plan, machine), "again", ".", machine);
  EXPECT_EQ(again.moves[1].kind, MoveKind::kLength);
  EXPECT_EQ(again.moves[1].feature, again.artifact.findFeature("p"));
  expectRefusal(beam + "moves: [{x_mm: 3, reference: length}]", "name the 'feature' it begins at");
  expectRefusal(beam + "moves: [{x_mm: 3, reference: length, feature: b}]", "'b' is a ball");
  expectRefusal(beam + "moves: [{x_mm: 3, reference: x, feature: p}]", "exclude each other");
}

TEST(Plan, WrittenOutItIsReadBackTheSame) {
  for (const auto& [name, machineName] :
       std::vector<std::pair<std::string, std::string>>{{"nine_ball_plate", "three_axis"},
                                                        {"interferometer", "three_axis"},
                                                        {"five_axis_ball", "five_axis"}}) {
    const Machine machine = Machine::load(machineName);
    const Plan plan = Plan::load("config/plans/" + name + ".yaml", machine);
    const Plan again = Plan::parse(planYaml(plan, machine), "again", ".", machine);
    ASSERT_EQ(plan.moves.size(), again.moves.size());
    EXPECT_EQ(plan.artifact.poseKnown, again.artifact.poseKnown);
    for (std::size_t i = 0; i < plan.moves.size(); ++i) {
      const PlanMove &a = plan.moves[i], &b = again.moves[i];
      ASSERT_EQ(a.kind, b.kind);
      EXPECT_EQ(a.feature, b.feature);
      EXPECT_EQ(a.setup, b.setup);
      EXPECT_NEAR(a.wait, b.wait, 1e-9);
      for (std::size_t j = 0; j < a.position.size(); ++j)
        ASSERT_NEAR(a.position[j], b.position[j], 1e-9) << name << ", move " << i;
      for (std::size_t j = 0; j < a.target.size(); ++j)
        ASSERT_NEAR(a.target[j], b.target[j], 1e-9) << name << ", move " << i;
    }
  }
}

TEST(Plan, RefusalsNameLineAndKey) {
  expectRefusal(kBall + "touch: {pionts: 3}", "plan.yaml:2: touch: unknown key 'pionts'");
  expectRefusal(kBall + "moves:\n  - {x_mm: 30}", "plan.yaml:3: a move: joint 'x' would move to 30");
  expectRefusal(kBall + "moves: [{x_mm: 9, y_mm: 5, z_mm: 3, feature: b0, approach: [0, 0, -1]}]",
                "passes 'b0'");
  expectRefusal(kBall + "moves: [{feature: b7}]", "'b7' is not in the artifact");
  expectRefusal(kBall + "moves: [{x_deg: 3}]", "unknown key 'x_deg'");
  expectRefusal(kBall + "moves: [{x_mm: no}]", "must be a finite number");
  expectRefusal(kBall + "moves: [{x_mm: 1}]", "measures nothing");
  expectRefusal(kBall + "touch: {points: 0}", "at least 1");
  expectRefusal(kBall + "touch: {points: 3}\ntouch: {points: 3}", "given twice");
  expectRefusal(kBall + "postures: {at: [{b_deg: 0}]}", "needs 'probe: laser'");
  expectRefusal("touch: [x", "not YAML");
  expectRefusal("reference: {joint: q, positions_mm: [1], runs: 1}", "'q' is not a joint");
  expectRefusal("reference: {joint: b, positions_mm: [1]}", "is for a linear joint", "five_axis");
  expectRefusal("artifact: missing.yaml\ntouch: {points: 3}", "missing.yaml");
}

TEST(Plan, MeasuresEveryPlacementWithEveryStylus) {
  const std::string plate =
      "artifact: {name: one, pose: free, probe: {styli: [{name: A, tip_radius_mm: 1}, {name: B, "
      "tip_radius_mm: 1, "
      "offset_mm: [2, 0, 0]}]}, balls: [{name: b0, centre_mm: [5, 5, -4], radius_mm: 4}]}\n"
      "placements: [{name: flat}, {name: turned, turn_deg: 90, about_mm: [0, 5, 0]}]\n";
  const Plan plan = parse(plate + "styli: all\nclearance: {z_mm: 10}\ntouch: {points: 3}\n");
  EXPECT_EQ(plan.measurements(), 2 * 2 * 3);
  EXPECT_NEAR((plan.placeOf(0, 1) - Eigen::Vector3d(0.0, 10e-3, -4e-3)).norm(), 0.0, 1e-12);
  for (const PlanMove& move : plan.moves) {
    if (move.kind != MoveKind::kTouch) continue;
    Eigen::Vector3d tip(move.target[0], move.target[1], move.target[2]);
    if (move.stylus == 1) tip.x() += 2e-3;
    EXPECT_LT((tip - plan.placeOf(0, move.placement)).norm(), 5e-3) << "into the ball, where it stands";
  }
  const Plan again = parse(planYaml(plan, Machine::load("three_axis")));
  ASSERT_EQ(again.moves.size(), plan.moves.size());
  EXPECT_EQ(again.moves.back().placement, plan.moves.back().placement);
  EXPECT_EQ(again.moves.back().stylus, plan.moves.back().stylus);
  EXPECT_EQ(plan.standText(plan.moves.back()), "placement 'turned', stylus 'B'");
  EXPECT_EQ(
      parse(plate + "touch: {points: 3, placement: turned}\nmoves: [{z_mm: 9, placement: flat, feature: b0, "
                    "x_mm: 5, y_mm: 5}]\n")
          .measurements(),
      4);
  expectRefusal(plate + "touch: {points: 3, placement: flat}\n",
                "names 'turned', in which nothing is measured");
  expectRefusal(plate + "touch: {points: 3, placement: falt}\n",
                "is 'falt', which is not among the plan's: flat, turned");
  expectRefusal(plate + "styli: [C]\ntouch: {points: 3}\n", "names 'C', which the artifact does not");
}

}  // namespace
}  // namespace mm
