#include "session/sphere_centre.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "base/units.h"
#include "session/geometric_start.h"

namespace mm {
namespace {

constexpr double kRadius = 5e-3;
const Eigen::Vector3d kCentre(0.1, -0.2, 0.3);

/// Points on a cap about +z of this half angle, on `rings` circles of twelve.
std::vector<Eigen::Vector3d> cap(double halfAngle, int rings) {
  std::vector<Eigen::Vector3d> points{kCentre + kRadius * Eigen::Vector3d::UnitZ()};
  for (int r = 1; r <= rings; ++r)
    for (int i = 0; i < 12; ++i) {
      const double polar = halfAngle * r / rings, azimuth = 2.0 * kPi * i / 12.0;
      points.push_back(kCentre + kRadius * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                                           std::sin(polar) * std::sin(azimuth),
                                                           std::cos(polar)));
    }
  return points;
}

TEST(SphereCentre, isFoundWithAndWithoutTheRadius) {
  const auto points = cap(100.0 * kDegree, 4);
  const auto algebraic = algebraicSphereCentre(points, kRadius, 1e-3);
  ASSERT_TRUE(algebraic);
  EXPECT_LT((*algebraic - kCentre).norm(), 1e-15);
  Eigen::Vector3d centre;
  ASSERT_TRUE(sphereCentre(points, kRadius, centre));
  EXPECT_LT((centre - kCentre).norm(), 1e-15);
}

TEST(SphereCentre, aFlatPatchDoesNotDetermineASphereOfUnknownRadius) {
  EXPECT_FALSE(algebraicSphereCentre(cap(0.5 * kDegree, 2), 1e-3, 1e-3));
  EXPECT_FALSE(algebraicSphereCentre({kCentre, kCentre, kCentre}, kRadius, 1e-3));
  EXPECT_FALSE(algebraicSphereCentre(std::vector<Eigen::Vector3d>(6, kCentre), 0.0, 1e-3));
}

TEST(SphereCentre, ofAShallowCapIsOnTheSideThatIsSaid) {
  const auto points = cap(8.0 * kDegree, 2);
  const Eigen::Vector3d above = kCentre + 2.0 * kRadius * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d nearTruth = kCentre + 1e-4 * Eigen::Vector3d::UnitX();
  Eigen::Vector3d centre;
  ASSERT_TRUE(sphereCentre(points, kRadius, centre, &nearTruth));
  EXPECT_LT((centre - kCentre).norm(), 1e-9);
  ASSERT_TRUE(sphereCentre(points, kRadius, centre, &above));
  EXPECT_GT(centre.z(), kCentre.z() + 1.5 * kRadius);  // the mirror image
}

TEST(RigidMotion, isARotationWhateverThePointsDetermine) {
  const Eigen::Matrix3d turned =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  const Eigen::Vector3d shift(0.01, 0.02, -0.03);
  Eigen::Matrix3Xd from(3, 4);
  from << 0, 0.03, 0, 0.01, 0, 0, 0.02, 0.01, 0, 0, 0, 0;  // in one plane: a reflection fits as well
  const RigidMotion motion = rigidMotion(from, (turned * from).colwise() + shift);
  EXPECT_LT((motion.rotation - turned).norm(), 1e-13);
  EXPECT_LT((motion.translation - shift).norm(), 1e-15);

  const Eigen::Matrix3Xd line = Eigen::Vector3d(0.01, 0.0, 0.0) * Eigen::RowVector3d(0, 1, 2);
  const Eigen::Matrix3d rotation = rigidMotion(line, turned * line).rotation;
  EXPECT_NEAR(rotation.determinant(), 1.0, 1e-14);
  EXPECT_LT((rotation * line - turned * line).norm(), 1e-15);

  // readings of one place that grew: their rotation was what the noise said
  Eigen::Matrix3Xd place = Eigen::Matrix3Xd::Zero(3, 50), grown = place;
  for (Eigen::Index i = 0; i < place.cols(); ++i)
    grown.col(i) = Eigen::Vector3d(0.2e-6 * std::sin(7.0 * i), 0.2e-6 * std::cos(5.0 * i), 0.1e-6 * i),
    place(0, i) = 1e-7 * std::sin(3.0 * i);
  EXPECT_LT((rigidMotion(grown, place).rotation - Eigen::Matrix3d::Identity()).norm(), 1e-3);
  const RigidMotion shifted = rigidMotion(from.leftCols<1>(), from.leftCols<1>().colwise() + shift);
  EXPECT_EQ(shifted.rotation, Eigen::Matrix3d::Identity());
  EXPECT_LT((shifted.translation - shift).norm(), 1e-18);
}

}  // namespace
}  // namespace mm
