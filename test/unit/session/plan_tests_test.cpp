#include "session/plan_tests.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.h"
#include "base/units.h"
#include "session/plan.h"
#include "session/plan_selection.h"

namespace mm {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Plan planOf(const std::string& test, const PlanTestSize& size = {}, const char* name = "three_axis") {
  const Machine machine = Machine::load(name);
  return Plan::parse(testPlan(test, size, machine, test), test + ".yaml", {}, machine);
}

std::string refusal(const std::string& test, const PlanTestSize& size, const Machine& machine) {
  try {
    Plan::parse(testPlan(test, size, machine, test), test, {}, machine);
  } catch (const InputError& e) {
    return e.what();
  }
  return {};
}

std::vector<PlanMove> readingsOf(const Plan& plan) {
  std::vector<PlanMove> readings;
  std::copy_if(plan.moves.begin(), plan.moves.end(), std::back_inserter(readings),
               [](const PlanMove& move) { return byInstrument(move.kind); });
  return readings;
}

/// When each move of a plan ends, s: the joints arrive together, then it waits.
std::vector<double> timesOf(const Plan& plan, const Machine& machine) {
  std::vector<double> times;
  double time = 0.0;
  for (std::size_t i = 0; i < plan.moves.size(); ++i) {
    double longest = 0.0;
    for (int j = 0; i > 0 && j < machine.jointCount(); ++j) {
      const auto joint = static_cast<std::size_t>(j);
      const bool linear = machine.joints()[joint].kind == JointKind::kLinear;
      const double way = std::abs(plan.moves[i].position[joint] - plan.moves[i - 1].position[joint]);
      longest = std::max(longest, way / (linear ? plan.rapid : plan.rapidRotary));
    }
    times.push_back(time += longest + plan.moves[i].wait);
  }
  return times;
}

/// Share of the way of a line at which each length of a beam was read, with its direction, in order.
struct BeamReading {
  double distance;  // m from the beam's point
  int way;          // +1: away from it
};
std::map<std::string, std::vector<BeamReading>> beamsOf(const Plan& plan, const Machine& machine) {
  std::map<std::string, std::vector<BeamReading>> beams;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (const PlanMove& move : plan.moves) {
    const Eigen::Vector3d tip = machine.nominal(move.position.data(), kNotMeasured).position;
    if (move.kind == MoveKind::kLength) {
      const Feature& from = plan.artifact.features[static_cast<std::size_t>(move.feature)];
      EXPECT_EQ(move.setup, from.name);
      beams[from.name].push_back(
          {(tip - from.position).norm(), (tip - before).dot(tip - from.position) > 0.0 ? 1 : -1});
    }
    before = tip;
  }
  return beams;
}

TEST(PlanTests, EachIsReadOnAMachineOfFiveAxesAndRefusedByItsReasonElsewhere) {
  const Machine five = Machine::load("five_axis"), three = Machine::load("three_axis");
  const Machine line(
      "<robot name='line'><link name='workpiece'/><link name='probe_tip'/>"
      "<joint name='x' type='prismatic'><parent link='workpiece'/><child link='probe_tip'/>"
      "<axis xyz='1 0 0'/><limit lower='0' upper='0.001' effort='1' velocity='0.1'/></joint></robot>",
      "line");
  const std::map<std::string, std::string> onThree = {
      {"rotary", "three_axis: --test rotary needs a rotary joint, and the machine has none"},
      {"rotation", "three_axis: --test rotation needs a rotary joint, and the machine has none"}};
  for (const PlanTest& test : planTests()) {
    EXPECT_EQ(refusal(test.name, {}, five), "") << test.name;
    const auto why = onThree.find(test.name);
    EXPECT_EQ(refusal(test.name, {}, three), why == onThree.end() ? "" : why->second);
    const bool stands = test.name == "etve" || test.name == "spindle";
    EXPECT_EQ(refusal(test.name, {}, line).empty(), stands) << test.name;
  }
  EXPECT_EQ(refusal("linear", {}, line),
            "line: --test linear needs a travel of 1.4 mm, and joint x has 1 mm");
  EXPECT_EQ(refusal("diagonal", {}, line),
            "line: --test diagonal needs 2 linear axes of different directions, and the machine has 1");
}

TEST(PlanTests, ASizeThatATestDoesNotHaveIsRefused) {
  const Machine machine = Machine::load("three_axis");
  EXPECT_EQ(refusal("circular", {0, 0, 3.0, 0.0}, machine), "--hours: --test circular has none");
  EXPECT_EQ(refusal("etve", {5, 0, 0.0, 0.0}, machine), "--positions: --test etve has none");
  EXPECT_EQ(refusal("diagonal", {4, 0, 0.0, 0.0}, machine),
            "--positions: is 4, but --test diagonal needs 5 or more");
  EXPECT_THAT(refusal("etv", {}, machine), HasSubstr("positioning, etve"));
}

/// A slow long bridge: 3000 x 1000 x 60 mm at 100 mm/s.
Machine longMachine() {
  const auto joint = [](const char* name, const char* parent, const char* child, const char* axis,
                        double length) {
    return std::string("<joint name='") + name + "' type='prismatic'><parent link='" + parent +
           "'/><child link='" + child + "'/><axis xyz='" + axis + "'/><limit lower='0' upper='" +
           std::to_string(length) + "' effort='1' velocity='0.1'/></joint>";
  };
  return Machine(
      "<robot name='bridge'><link name='workpiece'/><link name='a'/><link name='b'/>"
      "<link name='probe_tip'/>" +
          joint("x", "workpiece", "a", "1 0 0", 3.0) + joint("y", "a", "b", "0 1 0", 1.0) +
          joint("z", "b", "probe_tip", "0 0 1", 0.06) + "</robot>",
      "bridge");
}

Plan longPlan(const std::string& test, const PlanTestSize& size = {}) {
  const Machine machine = longMachine();
  return Plan::parse(testPlan(test, size, machine, test), test + ".yaml", {}, machine);
}

TEST(PlanTests, ALongAxisHasFiveTargetsAMetreAndRefusesFewer) {
  std::map<int, std::set<long>> targets;
  for (const PlanMove& move : readingsOf(longPlan("positioning")))
    targets[move.joint].insert(std::lround(move.position[static_cast<std::size_t>(move.joint)] * 1e6));
  EXPECT_EQ(targets[0].size(), 15U);  // over 2.87 m
  EXPECT_EQ(targets[1].size(), 11U);
  std::set<long> steps;  // no multiple of one pitch
  for (auto at = targets[1].begin(); std::next(at) != targets[1].end(); ++at)
    steps.insert(*std::next(at) - *at);
  EXPECT_GT(*steps.rbegin() - *steps.begin(), 10000);  // um
  const std::string why = refusal("positioning", {11, 0, 0.0, 0.0}, longMachine());
  EXPECT_THAT(why, HasSubstr("needs --positions 15 or more, not 11: joint x"));
  EXPECT_EQ(refusal("positioning", {15, 0, 0.0, 0.0}, longMachine()), "");

  const Machine machine = longMachine();
  const auto beams = beamsOf(longPlan("diagonal", {0, 1, 0.0, 0.0}), machine);
  EXPECT_EQ(beams.at("+x+y+z").size(), 2U * 16);  // over 3.03 m
  EXPECT_EQ(beams.at("+y+z").size(), 2U * 11);
  EXPECT_THAT(refusal("diagonal", {11, 0, 0.0, 0.0}, machine), HasSubstr("diagonal +x+y+z"));
}

TEST(PlanTests, ALineIsReachedFromBeyondItsEndsByEveryJoint) {
  const Plan plan = longPlan("diagonal", {0, 1, 0.0, 0.0});
  std::size_t ends = 0;
  for (std::size_t i = 0; i + 1 < plan.moves.size(); ++i) {
    if (plan.moves[i].kind != MoveKind::kGo) continue;
    ++ends;
    for (std::size_t j = 0; j < 3; ++j) {
      const double way = std::abs(plan.moves[i + 1].position[j] - plan.moves[i].position[j]);
      EXPECT_TRUE(way == 0.0 || way > 0.49e-3) << "move " << i << ", joint " << j << ": " << way;
    }
  }
  EXPECT_EQ(ends, 20U);
}

TEST(PlanTests, ALongAxisKeepsItsHoursOrSaysWhichItNeeds) {
  const Machine machine = longMachine();
  const Plan plan = longPlan("linear");
  const std::vector<double> times = timesOf(plan, machine);
  for (int joint = 0; joint < 3; ++joint) {
    std::vector<double> when;  // of the last reading of each group of three
    for (std::size_t i = 0; i < plan.moves.size(); ++i)
      if (plan.moves[i].joint == joint && (i + 1 == plan.moves.size() || plan.moves[i + 1].joint != joint))
        when.push_back(times[i]);
    ASSERT_EQ(when.size(), 1U + 48 + 12);
    EXPECT_NEAR(when[48] - when[0], 4 * 3600.0, 0.02 * 4 * 3600.0) << joint;
    EXPECT_NEAR(when[60] - when[48], 3600.0, 0.02 * 3600.0) << joint;
  }
  EXPECT_THAT(refusal("linear", {0, 0, 0.0, 1.0}, machine), HasSubstr("needs --every-min 1.3 or more"));
  EXPECT_EQ(refusal("linear", {0, 0, 0.0, 1.3}, machine), "");
  EXPECT_THAT(refusal("rotary", {0, 0, 0.0, 0.1}, Machine::load("five_axis")),
              HasSubstr("once to and fro of joint"));
}

TEST(PlanTests, PositioningReadsEveryJointAtItsTargetsFromBothSides) {
  const Plan plan = planOf("positioning", {8, 2, 0.0, 0.0}, "five_axis");
  std::map<std::string, std::map<long, std::set<int>>> sides;  // setup, position, direction
  for (std::size_t i = 1; i < plan.moves.size(); ++i) {
    const PlanMove& move = plan.moves[i];
    if (move.kind != MoveKind::kDeviation) continue;
    const auto joint = static_cast<std::size_t>(move.joint);
    const double way = move.position[joint] - plan.moves[i - 1].position[joint];
    sides[move.setup][std::lround(move.position[joint] * 1e6)].insert(way > 0.0 ? 1 : -1);
  }
  EXPECT_EQ(sides.size(), 5U);
  for (const auto& [setup, targets] : sides) {
    EXPECT_EQ(targets.size(), 8U) << setup;
    for (const auto& [position, ways] : targets) EXPECT_EQ(ways.size(), 2U) << setup << " at " << position;
  }
  EXPECT_EQ(plan.measurements(), 5 * 8 * 2 * 2);
}

TEST(PlanTests, EtveStandsAtOnePlaceForADay) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = planOf("etve");
  EXPECT_EQ(plan.measurements(), 24 * 12 + 1);
  for (const PlanMove& move : plan.moves) {
    EXPECT_EQ(move.kind, MoveKind::kPosition);
    EXPECT_EQ(move.position, plan.moves.front().position);
  }
  const std::vector<double> times = timesOf(plan, machine);
  EXPECT_NEAR(times.back() - times.front(), 24 * 3600.0, 1.0);
  EXPECT_EQ(planOf("etve", {0, 0, 2.0, 10.0}).measurements(), 2 * 6 + 1);
}

TEST(PlanTests, ASpindleTurnsThenStandsForAQuarterOfTheTime) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = planOf("spindle");
  EXPECT_EQ(plan.measurements(), 1 + 4 * 12 + 12);
  const std::vector<double> times = timesOf(plan, machine);
  EXPECT_NEAR(times.back() - times.front(), 5 * 3600.0, 1.0);
  EXPECT_THAT(plan.text, HasSubstr("name: spindle, unit: rpm"));
}

TEST(PlanTests, AMovingLinearAxisIsReadAtItsEndsFromOneSideWhileItWarmsAndCools) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = planOf("linear");
  const std::vector<double> times = timesOf(plan, machine);
  EXPECT_DOUBLE_EQ(plan.rapid, machine.joints()[0].maxVelocity);
  for (int joint = 0; joint < 3; ++joint) {
    const auto j = static_cast<std::size_t>(joint);
    std::set<long> places;
    std::vector<double> at, when;  // of the readings at the lower end
    double travelled = 0.0;
    for (std::size_t i = 1; i < plan.moves.size(); ++i) {
      const PlanMove& move = plan.moves[i];
      const double way = move.position[j] - plan.moves[i - 1].position[j];
      travelled += std::abs(way);
      if (move.joint != joint) continue;
      EXPECT_GT(way, 0.0);
      places.insert(std::lround(move.position[j] * 1e6));
      if (*places.begin() == std::lround(move.position[j] * 1e6)) {
        at.push_back(travelled);
        when.push_back(times[i]);
      }
    }
    ASSERT_EQ(places.size(), 3U);
    const double span = (*places.rbegin() - *places.begin()) * 1e-6;
    EXPECT_GT(span, 0.85 * (machine.joints()[j].upper - machine.joints()[j].lower));
    ASSERT_EQ(when.size(), 1U + 48 + 12);
    EXPECT_NEAR(when[48] - when[0], 4 * 3600.0, 1.0);
    EXPECT_NEAR(when[60] - when[48], 3600.0, 1.0);
    EXPECT_GT((at[48] - at[0]) / (when[48] - when[0]), 0.9 * plan.rapid);  // hardly ever stands
    EXPECT_NEAR(at[60] - at[48], 12 * 2.0 * span, 12 * 2e-3);              // only for the readings
  }
}

TEST(PlanTests, ARotaryAxisSwingsAndIsReadAtOnePlace) {
  const Machine machine = Machine::load("five_axis");
  const Plan plan = planOf("rotary", {}, "five_axis");
  const std::vector<PlanMove> readings = readingsOf(plan);
  ASSERT_EQ(readings.size(), 2U * (1 + 48 + 12));
  for (const PlanMove& move : readings) EXPECT_EQ(move.position, readings.front().position);
  EXPECT_EQ(readings.front().setup, "b");
  EXPECT_EQ(readings.back().setup, "a");
  const std::vector<double> times = timesOf(plan, machine);
  EXPECT_NEAR(times.back(), 10 * 3600.0, 60.0);
  double turned = 0.0;
  for (std::size_t i = 1; i < plan.moves.size(); ++i)
    turned += std::abs(plan.moves[i].position[3] - plan.moves[i - 1].position[3]);
  EXPECT_GT(turned, 0.9 * plan.rapidRotary * 4 * 3600.0);
}

TEST(PlanTests, CirclesAreReadInBothSensesInEachPlane) {
  const Plan plan = planOf("circular");
  std::size_t runIns = 0;
  for (std::size_t i = 0; i + 1 < plan.moves.size(); ++i) {
    if (plan.moves[i].kind != MoveKind::kGo) continue;
    ++runIns;  // as far from the first point as two points are from each other
    double way = 0.0, step = 0.0;
    for (std::size_t j = 0; j < 3; ++j) {
      way += std::pow(plan.moves[i + 1].position[j] - plan.moves[i].position[j], 2);
      step += std::pow(plan.moves[i + 2].position[j] - plan.moves[i + 1].position[j], 2);
    }
    EXPECT_NEAR(std::sqrt(way), std::sqrt(step), 1e-8);
  }
  EXPECT_EQ(runIns, 2U * 3);
  std::map<std::string, std::vector<double>> angles;
  for (const PlanMove& move : readingsOf(plan)) {
    const std::size_t first = std::string("xyz").find(move.setup[0]), second = (first + 1) % 3;
    double centre[2] = {0.0, 0.0};
    int count = 0;
    for (const PlanMove& other : plan.moves)
      if (other.setup == move.setup && ++count <= 36) {
        centre[0] += other.position[first] / 36.0;
        centre[1] += other.position[second] / 36.0;
      }
    angles[move.setup].push_back(
        std::atan2(move.position[second] - centre[1], move.position[first] - centre[0]));
  }
  ASSERT_EQ(angles.size(), 3U);
  for (const auto& [setup, list] : angles) {
    double ccw = 0.0, cw = 0.0;
    for (std::size_t i = 1; i < list.size(); ++i) {
      const double step = std::remainder(list[i] - list[i - 1], 2.0 * kPi);
      (step > 0.0 ? ccw : cw) += step;
    }
    EXPECT_NEAR(ccw, 2.0 * kPi, 1e-6) << setup;
    EXPECT_NEAR(cw, -2.0 * kPi, 1e-6) << setup;
  }
}

TEST(PlanTests, DiagonalsOfBodyAndFacesAreReadToAndFro) {
  for (const char* name : {"three_axis", "five_axis"}) {
    const Machine machine = Machine::load(name);
    const Plan plan = planOf("diagonal", {5, 2, 0.0, 0.0}, name);
    const auto beams = beamsOf(plan, machine);
    EXPECT_EQ(beams.size(), 10U);
    for (const char* body : {"+x+y+z", "+x+y-z", "+x-y+z", "-x+y+z"})
      EXPECT_EQ(beams.count(body), 1U) << body;
    for (const auto& [beam, readings] : beams) {
      std::map<long, std::multiset<int>> targets;
      for (const BeamReading& r : readings) targets[std::lround(r.distance * 1e7)].insert(r.way);
      ASSERT_EQ(targets.size(), 5U) << name << " " << beam;
      for (const auto& [distance, ways] : targets) {
        EXPECT_EQ(ways.count(1), 2U) << beam;
        EXPECT_EQ(ways.count(-1), 2U) << beam;
      }
    }
    // The four body diagonals of a cuboid are of one length, and longer than those of its faces.
    const auto spanOf = [&](const std::string& beam) {
      const auto& all = beams.at(beam);
      return std::abs(all.front().distance - all[4].distance);
    };
    EXPECT_NEAR(spanOf("+x+y+z"), spanOf("-x+y+z"), 1e-9);
    EXPECT_GT(spanOf("+x+y-z"), spanOf("+x+y"));
  }
}

TEST(PlanTests, RotationIsReadBothWaysRunAfterRun) {
  const Plan plan = planOf("rotation", {13, 2, 0.0, 0.0}, "five_axis");
  EXPECT_EQ(plan.measurements(), 2 * 13 * 2 * 2);
  std::set<long> angles;
  for (const PlanMove& move : readingsOf(plan)) {
    EXPECT_EQ(move.position[0], plan.moves.front().position[0]);
    if (move.setup == "a") angles.insert(std::lround(move.position[4] * 1e6));
  }
  EXPECT_EQ(angles.size(), 13U);
  EXPECT_GT(*angles.rbegin() - *angles.begin(), std::lround(180.0 * kDegree * 1e6));
}

TEST(PlanTests, ALengthTestHasAHundredAndFiveLengthsWithEachEndFromOutside) {
  const Machine machine = Machine::load("three_axis");
  const auto beams = beamsOf(planOf("length"), machine);
  ASSERT_EQ(beams.size(), 7U);
  int lengths = 0;
  for (const auto& [beam, readings] : beams) {
    std::map<long, int> times;
    for (std::size_t i = 0; i + 1 < readings.size(); i += 2) {
      EXPECT_EQ(readings[i].way, 1) << beam;
      EXPECT_EQ(readings[i + 1].way, -1) << beam;
      ++times[std::lround((readings[i + 1].distance - readings[i].distance) * 1e7)];
      ++lengths;
    }
    EXPECT_EQ(times.size(), 5U);
    for (const auto& [length, count] : times) EXPECT_EQ(count, 3) << beam;
  }
  EXPECT_EQ(lengths, 105);
}

TEST(PlanTests, WhatIsPlannedIsASessionOfTheSameRows) {
  const Machine machine = Machine::load("three_axis");
  const Plan plan = planOf("length");
  const Session session = plannedSession(plan, machine, nullptr);
  ASSERT_EQ(session.observations.size(), 210U);
  EXPECT_EQ(session.observations.front().kind, ObservationKind::kLength);
  EXPECT_NEAR(session.observations.front().length, 0.1, 1e-9);  // where the beam begins
  EXPECT_EQ(session.setups.size(), 7U);
  EXPECT_FALSE(plannedSession(planOf("etve"), machine, nullptr).poseFree(0));
}

}  // namespace
}  // namespace mm
