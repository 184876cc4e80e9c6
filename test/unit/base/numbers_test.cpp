// What several folders compute with: random numbers, Legendre polynomials, rotations.
#include <gtest/gtest.h>

#include <cmath>

#include "base/legendre.h"
#include "base/random.h"
#include "base/rotation.h"
#include "base/unit_random.h"

namespace mm {
namespace {

TEST(UnitRandom, isThatOfTheStandardsEngine) {
  std::mt19937_64 engine;  // its 10000th number is fixed by the standard
  engine.discard(9999);
  EXPECT_EQ(unitRandom(engine), std::ldexp(static_cast<double>(9981545732273789042ULL >> 11), -53));
}

TEST(Random, streamsAreIndependentAndRepeatable) {
  Random a(5, "noise"), again(5, "noise"), other(5, "wander");
  const double first = a.uniform();
  EXPECT_EQ(first, again.uniform());
  EXPECT_NE(first, other.uniform());
  double sum = 0.0, squares = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double x = a.normal();
    sum += x, squares += x * x;
  }
  EXPECT_NEAR(sum / 20000.0, 0.0, 0.03);
  EXPECT_NEAR(squares / 20000.0, 1.0, 0.04);
}

TEST(Legendre, alsoBeyondOne) {
  for (const double u : {-1.3, -0.4, 0.0, 0.7, 1.0, 1.2}) {
    EXPECT_EQ(legendre(0, u), 1.0);
    EXPECT_EQ(legendre(1, u), u);
    EXPECT_NEAR(legendre(2, u), 0.5 * (3.0 * u * u - 1.0), 1e-14);
    EXPECT_NEAR(legendre(5, u), (63.0 * std::pow(u, 5) - 70.0 * std::pow(u, 3) + 15.0 * u) / 8.0, 1e-13);
  }
}

TEST(Rotation, byAVectorIsTheExponentialOfItsSkewMatrix) {
  const Eigen::Vector3d w(0.02, -0.01, 0.03), v(1.0, 2.0, 3.0);
  EXPECT_EQ(skew(w) * v, w.cross(v));
  Eigen::Matrix3d sum = Eigen::Matrix3d::Identity(), term = sum;
  for (int n = 1; n < 12; ++n) sum += term = term * skew(w) / n;
  EXPECT_LT((rotationBy(w) - sum).norm(), 1e-15);
  for (const double size : {1.0, 1e-6, 1e-12})
    EXPECT_LT((rotationVectorOf(rotationBy(size * w)) - size * w).norm(), 1e-15 * (1.0 + size)) << size;
  EXPECT_EQ(rotationVectorOf(Eigen::Matrix3d::Identity()), Eigen::Vector3d::Zero());
  EXPECT_EQ(rotationBy(Eigen::Vector3d::Zero()), Eigen::Matrix3d::Identity());
}

}  // namespace
}  // namespace mm
