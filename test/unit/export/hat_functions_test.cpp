// Straight lines between points, fitted to samples between them.
#include "export/hat_functions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

std::vector<double> pointsTo(double end, int steps) {
  std::vector<double> points;
  for (int i = 0; i <= steps; ++i) points.push_back(end * i / steps);
  return points;
}

Eigen::MatrixXd sine(const std::vector<double>& at, double period) {
  Eigen::MatrixXd values(static_cast<Eigen::Index>(at.size()), 1);
  for (std::size_t n = 0; n < at.size(); ++n)
    values(static_cast<Eigen::Index>(n), 0) = std::sin(2.0 * kPi * at[n] / period);
  return values;
}

double rms(const Eigen::MatrixXd& values) {
  return values.norm() / std::sqrt(static_cast<double>(values.rows()));
}

TEST(HatFunctions, SamplesStandInTheirPartsAndOnNoPeriod) {
  const std::vector<double> points = pointsTo(1.0, 10), at = samplesWithin(points, 4);
  ASSERT_EQ(at.size(), 40u);
  for (std::size_t n = 0; n < at.size(); ++n) {
    EXPECT_GE(at[n], static_cast<double>(n) / 40.0);
    EXPECT_LT(at[n], static_cast<double>(n + 1) / 40.0);
  }
  // A wave of the samples' mean distance is seen whole.
  EXPECT_NEAR(rms(sine(at, 1.0 / 40.0)), std::sqrt(0.5), 0.03);
}

TEST(HatFunctions, APolygonComesBack) {
  const std::vector<double> points = pointsTo(2.0, 5), at = samplesWithin(points, 4);
  Eigen::MatrixXd corners(6, 2);
  corners << 1, 0, -2, 3, 5, 3, 0, 1, 7, -2, 2, 2;
  const Eigen::MatrixXd none = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(at.size()), 2);
  const Eigen::MatrixXd samples = -hatRemainder(points, corners, at, none);
  EXPECT_LT((hatFit(points, at, samples) - corners).norm(), 1e-12);
  EXPECT_LT((hatOrLineFit(points, at, samples) - corners).norm(), 1e-12);
}

TEST(HatFunctions, WhatIsShorterThanTheStepsIsLeftAlone) {
  const std::vector<double> points = pointsTo(1.0, 20), at = samplesWithin(points, 8);
  const std::vector<double> fresh = samplesWithin(pointsTo(1.0, 7), 200);
  for (double waves = 30.0; waves < 400.0; waves *= 1.07) {  // 1.5 to 20 a step
    const Eigen::MatrixXd values = hatOrLineFit(points, at, sine(at, 1.0 / waves));
    const Eigen::MatrixXd there = sine(fresh, 1.0 / waves);
    EXPECT_LT(rms(hatRemainder(points, values, fresh, there)), 1.03 * rms(there)) << waves;
  }
  const Eigen::MatrixXd slow = sine(at, 0.5);  // ten steps a wave
  EXPECT_LT(rms(hatRemainder(points, hatOrLineFit(points, at, slow), at, slow)), 0.03);
}

}  // namespace
}  // namespace mm
