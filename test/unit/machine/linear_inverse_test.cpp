#include "machine/linear_inverse.h"

#include <gtest/gtest.h>

#include <limits>

namespace mm {
namespace {

constexpr double kTouching = std::numeric_limits<double>::quiet_NaN();

TEST(LinearInverse, putsTheProbeOnATargetInOneStepInAnyPosture) {
  const Machine machine = Machine::load("five_axis");
  const int a = machine.findJoint("a"), b = machine.findJoint("b");
  const Eigen::Vector3d target(0.011, -0.023, 0.007);
  for (const double reading : {kTouching, 0.4e-3}) {
    std::vector<double> q(5, 0.0);
    q[a] = 0.7, q[b] = -1.1;
    ASSERT_TRUE(placeTip(machine, target, reading, q));
    EXPECT_LT((machine.nominal(q.data(), reading).position - target).norm(), 1e-15);
    EXPECT_EQ(q[a], 0.7);
    EXPECT_EQ(q[b], -1.1);
  }
}

TEST(LinearInverse, refusesWhereTheLinearJointsDoNotReachEveryDirection) {
  const Machine machine = Machine::load("three_axis");
  const std::vector<int> linear = {0, 1};  // a machine without its z
  const Eigen::Matrix3Xd byJoint = Eigen::Matrix3Xd::Identity(3, 3);
  const LinearMotion motion = linearMotion(linear, byJoint, {3e-3, 0.0, 4e-3});
  EXPECT_FALSE(motion.everyDirection);
  EXPECT_DOUBLE_EQ(motion.change[0], 3e-3);
  EXPECT_EQ(motion.change[2], 0.0);
  EXPECT_DOUBLE_EQ(motion.missed, 4e-3);
  EXPECT_TRUE(linearMotion(linearJoints(machine.joints()), byJoint, {3e-3, 0.0, 4e-3}).everyDirection);
}

TEST(LinearInverse, takesTheShortestWayOfFourLinearJoints) {
  Eigen::Matrix3Xd byJoint = Eigen::Matrix3Xd::Zero(3, 4);
  byJoint.leftCols<3>().setIdentity();
  byJoint.col(3) = Eigen::Vector3d::UnitX();  // a second slide along x
  const LinearMotion motion = linearMotion({0, 1, 2, 3}, byJoint, {2e-3, 1e-3, 0.0});
  EXPECT_TRUE(motion.everyDirection);
  EXPECT_NEAR(motion.change[0], 1e-3, 1e-15);
  EXPECT_NEAR(motion.change[3], 1e-3, 1e-15);
}

TEST(LinearInverse, limitsHoldWithTheirSlackAndOnlyWhereThereAreSome) {
  std::vector<Joint> joints(2);
  joints[0].lower = -1e-3, joints[0].upper = 1e-3;  // the second has none: lower = upper
  EXPECT_TRUE(withinLimits(joints, {1e-3, 5.0}));
  EXPECT_FALSE(withinLimits(joints, {1.1e-3, 0.0}));
  EXPECT_TRUE(withinLimits(joints, {1.1e-3, 0.0}, 0.2e-3));
  EXPECT_FALSE(withinLimits(joints, {-1.3e-3, 0.0}, 0.2e-3));
}

}  // namespace
}  // namespace mm
