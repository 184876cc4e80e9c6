#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "compensation_support.h"

namespace mm {
namespace {

using test::calibrationOf, test::kUnknown, test::mmtByHand, test::mmtCalibration, test::stateAt;

TEST(CorrectTarget, findsTheReadingsThatReachATruePointOnThreeAxes) {
  const Calibration c = mmtCalibration(Machine::load("three_axis"));
  const Compensator compensator(c);
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-0.014, 0.014);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d target(u(random), u(random), u(random));
    const TargetReadings found = compensator.correctTarget(target, stateAt(compensator, {0, 0, 0}));
    ASSERT_TRUE(found.reached) << found.reason;
    EXPECT_LT((mmtByHand(c, {found.position[0], found.position[1], found.position[2]}) - target).norm(),
              1e-9);
    EXPECT_GT(found.sigma, 0.0);
    EXPECT_LE(found.iterations, 20);
  }
}

TEST(CorrectTarget, keepsTheRotaryReadings) {
  const Machine machine = Machine::load("five_axis");
  const Calibration c = mmtCalibration(machine);
  const Compensator compensator(c);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int i = 0; i < 50; ++i) {
    std::vector<double> there;
    for (const Joint& joint : machine.joints()) {
      const bool linear = joint.kind == JointKind::kLinear;
      // x and y of this machine only have positive readings
      there.push_back(linear ? (joint.name == "z" ? 0.01 * u(random) : 0.010 + 0.005 * u(random))
                             : 0.9 * u(random));
    }
    // The chain with eq. (13) on its three linear axes, written out.
    const int x = machine.findJoint("x"), y = machine.findJoint("y"), z = machine.findJoint("z");
    const auto truePoint = [&](std::vector<double> q) {
      const Eigen::Vector3d moved = mmtByHand(c, {q[x], q[y], q[z]});
      q[x] = moved.x();
      q[y] = moved.y();
      q[z] = moved.z();
      return machine.nominal(q.data(), kUnknown).position;
    };
    std::vector<double> start = there;
    start[x] = 0.010;
    start[y] = 0.012;
    start[z] = 0.0;
    const TargetReadings found = compensator.correctTarget(truePoint(there), stateAt(compensator, start));
    ASSERT_TRUE(found.reached) << found.reason;
    for (int j = 0; j < 5; ++j) {
      if (machine.joints()[j].kind == JointKind::kRotary) {
        EXPECT_EQ(found.position[j], there[j]);
      }
      EXPECT_NEAR(found.position[j], there[j], 1e-9);
    }
    EXPECT_LT((truePoint(found.position) - truePoint(there)).norm(), 1e-9);
  }
}

TEST(CorrectTarget, knowsTheTravelFromTheMove) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = 4e-6;
  const Compensator compensator(c);
  const TargetReadings up = compensator.correctTarget({0.010, 0, 0}, stateAt(compensator, {0, 0, 0}));
  ASSERT_TRUE(up.reached) << up.reason;
  EXPECT_NEAR(up.position[0], 0.010 + 2e-6, 1e-12);
  const TargetReadings down = compensator.correctTarget({-0.010, 0, 0}, stateAt(compensator, {0, 0, 0}));
  EXPECT_NEAR(down.position[0], -0.010 - 2e-6, 1e-12);
  State fromAbove = stateAt(compensator, {0, 0, 0});
  fromAbove.travel[0] = -1;  // of the last motion: the coming one goes up
  EXPECT_NEAR(compensator.correctTarget({0.010, 0, 0}, fromAbove).position[0], 0.010 + 2e-6, 1e-12);
  EXPECT_NEAR(compensator.correctTarget({0.010, 0, 0}, fromAbove, {-1, 0, 0}).position[0], 0.010 - 2e-6,
              1e-12)
      << "told";
}

/// Twelve targets, one after the other, each from where the machine is then, with the direction of its last
/// motion: none may be missed by the play.
TEST(CorrectTarget, plansForTheComingMoveWhateverTheLastOneWas) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = 4.03e-6;
  const Compensator compensator(c);
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> u(-0.014, 0.014);
  double reading = 0.0, slide = -0.5 * 4.03e-6, last = 1.0;  // a play operator of its own
  for (int i = 0; i < 12; ++i) {
    MovingState now = stateAt(compensator, {reading, 0, 0});
    now.travel[0] = last;
    now.sinceReversal = {1e-3, kUnknown, kUnknown};
    const double target = u(random);
    const TargetReadings found = compensator.correctTarget({target, 0, 0}, now);
    ASSERT_TRUE(found.reached) << found.reason;
    last = found.position[0] > reading ? 1.0 : -1.0;
    reading = found.position[0];
    slide = std::clamp(slide, reading - 0.5 * 4.03e-6, reading + 0.5 * 4.03e-6);
    EXPECT_NEAR(slide, target, 1e-11) << "target " << i;
  }
}

/// A controller that takes up more than there is: the gap is negative, and a target near the present place
/// lies behind the machine whichever way it goes.
TEST(CorrectTarget, aTargetNearerThanANegativePlayIsApproachedUpwardsAndSaysSo) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = -4e-6;
  const Compensator compensator(c);
  const TargetReadings found = compensator.correctTarget({1e-6, 0, 0}, stateAt(compensator, {0, 0, 0}));
  ASSERT_TRUE(found.reached) << found.reason;
  EXPECT_NE(found.correction.note.find("nearer than the backlash of x"), std::string::npos)
      << found.correction.note;
  EXPECT_NEAR(found.position[0], -1e-6, 1e-11);
}

TEST(CorrectTarget, itsSigmaSaysWhenTheMoveIsTooShortToTakeUpThePlay) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = 4e-6;
  const Compensator compensator(c);
  MovingState now = stateAt(compensator, {0, 0, 0});
  now.travel[0] = -1;
  now.sinceReversal = {1e-6, kUnknown, kUnknown};
  EXPECT_LT(compensator.correctTarget({1e-3, 0, 0}, now).sigma, 1e-7);
  EXPECT_LT(compensator.correctTarget({-1e-3, 0, 0}, now).sigma, 1e-7);
  const TargetReadings within = compensator.correctTarget({1.5e-6, 0, 0}, now);  // half a micrometre further
  ASSERT_TRUE(within.reached) << within.reason;
  EXPECT_NEAR(within.sigma, 2.5e-6 / std::sqrt(3.0), 1e-8);
  EXPECT_NE(within.correction.note.find("backlash of x is being taken up"), std::string::npos);
}

TEST(CorrectTarget, saysWhyATargetIsNotReached) {
  const Compensator compensator(mmtCalibration(Machine::load("three_axis")));
  const State start = stateAt(compensator, {0, 0, 0});
  const TargetReadings far = compensator.correctTarget({0.1, 0, 0}, start);
  EXPECT_FALSE(far.reached);
  EXPECT_NE(far.reason.find("x = "), std::string::npos) << far.reason;
  const TargetReadings limit =
      compensator.correctTarget({0, -0.018, 0}, start);  // calibrated, but the axis ends at -15 mm
  EXPECT_FALSE(limit.reached);
  EXPECT_NE(limit.reason.find("limits"), std::string::npos) << limit.reason;
  EXPECT_FALSE(compensator.correctTarget({kUnknown, 0, 0}, start).reached);
}

TEST(CorrectTarget, usesAllJointsWhereTheLinearOnesDoNotSuffice) {
  const std::string joint = "<limit lower='-3' upper='3' effort='1' velocity='1'/>";
  const std::string arm =
      "<robot name='arm'><link name='workpiece'/><link name='l1'/><link name='l2'/><link name='l3'/><link "
      "name='probe_tip'/>"
      "<joint name='turn' type='revolute'><parent link='workpiece'/><child link='l1'/><axis xyz='0 0 1'/>" +
      joint +
      "</joint><joint name='lift' type='revolute'><parent link='l1'/><child link='l2'/><axis xyz='0 1 0'/>" +
      joint +
      "</joint><joint name='bend' type='revolute'><parent link='l2'/><child link='l3'/><origin xyz='0.3 0 "
      "0'/>"
      "<axis xyz='0 1 0'/>" +
      joint +
      "</joint><joint name='tip' type='fixed'><parent link='l3'/><child link='probe_tip'/><origin xyz='0.2 0 "
      "0'/></joint></robot>";
  const Machine machine(arm, "arm.urdf");
  Calibration c = calibrationOf(machine, {EffectSpec("scale").set("axis", "bend")});
  c.values[0].value = 1e-3;
  const Compensator compensator(c);
  const double there[] = {0.3, -0.4, 0.9 * 1.001};
  const Eigen::Vector3d target = machine.nominal(there, kUnknown).position;
  const TargetReadings found = compensator.correctTarget(target, stateAt(compensator, {0.2, -0.2, 0.7}));
  ASSERT_TRUE(found.reached) << found.reason;
  EXPECT_NEAR(found.position[2], 0.9, 1e-9);
}

}  // namespace
}  // namespace mm
