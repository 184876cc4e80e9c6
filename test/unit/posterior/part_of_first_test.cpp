#include "posterior/part_of_first.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace mm {
namespace {

/// By drawing: the share of coefficients of which the second is a part of the first.
double drawn(const Eigen::Vector2d& mean, const Eigen::Matrix2d& covariance) {
  constexpr int kDraws = 400000;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d factor = covariance.llt().matrixL();
  int count = 0;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector2d c = mean + factor * Eigen::Vector2d(normal(random), normal(random));
    count += c[1] > 0.0 && c[1] < c[0];
  }
  return static_cast<double>(count) / kDraws;
}

TEST(PartOfFirst, IsTheShareOfCoefficientsThatAreSuch) {
  Eigen::Matrix2d covariance;
  for (const double correlation : {-0.9, 0.0, 0.6, 0.95})
    for (const Eigen::Vector2d& mean : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1.0, 0.4),
                                        Eigen::Vector2d(-1.5, -0.7), Eigen::Vector2d(0.5, 1.2)}) {
      covariance << 1.0, 0.7 * correlation, 0.7 * correlation, 0.49;
      const double share = drawn(mean, covariance);
      EXPECT_NEAR(std::exp(logPartOfFirst(mean, covariance)), share, 0.004)
          << mean.transpose() << ", correlation " << correlation;
    }
}

TEST(PartOfFirst, OfIndependentCoefficientsAboutZeroOneInEightIsSuch) {
  EXPECT_NEAR(logPartOfFirst(Eigen::Vector2d(0.0, 0.0), Eigen::Matrix2d::Identity()), std::log(0.125), 1e-9);
}

TEST(PartOfFirst, AtEachSizeItIsThatOfTheCoefficientsThatAreExpectedThen) {
  Eigen::Matrix3d products;
  products << 40.0, 25.0, 3.0, 25.0, 30.0, -4.0, 3.0, -4.0, 9.0;
  const Eigen::Vector3d target(30.0, 22.0, 1.0);
  constexpr double kRest = 60.0, kFreedoms = 38.0;
  const Sizes logs = logPartOfFirst(products, target, kRest, kFreedoms);
  for (int s = 0; s < kSizes; ++s) {
    const Eigen::Matrix3d known = Eigen::Matrix3d::Identity() / (sizeGrid()[s] * sizeGrid()[s]);
    const Eigen::Matrix3d covariance = (products + known).inverse();
    const Eigen::Vector3d mean = covariance * target;
    const double variance = (kRest - mean.dot(target)) / kFreedoms;
    const Eigen::Matrix2d ofTwo = variance * covariance.topLeftCorner<2, 2>();
    EXPECT_NEAR(logs[s], logPartOfFirst(Eigen::Vector2d(mean.head<2>()), ofTwo), 1e-9) << sizeGrid()[s];
  }
}

TEST(PartOfFirst, MoreAtOnceThanIsLostInAllIsAsGoodAsImpossible) {
  const Eigen::Matrix2d sure = 1e-2 * Eigen::Matrix2d::Identity();
  EXPECT_NEAR(logPartOfFirst(Eigen::Vector2d(10.0, 4.0), sure), 0.0, 1e-6);
  EXPECT_LT(logPartOfFirst(Eigen::Vector2d(10.0, 14.0), sure), -15.0);
  EXPECT_LT(logPartOfFirst(Eigen::Vector2d(-9.0, 27.0), sure), -15.0);
  EXPECT_LT(logPartOfFirst(Eigen::Vector2d(-10.0, -4.0), sure), -15.0);
}

TEST(PartOfFirst, WhatIsFurtherFromPossibleIsLessProbable) {
  const Eigen::Matrix2d sure = 1e-2 * Eigen::Matrix2d::Identity();
  double last = 0.0;
  for (const double at : {10.0, 11.0, 12.0, 15.0, 30.0, 100.0}) {
    const double log = logPartOfFirst(Eigen::Vector2d(10.0, at), sure);
    EXPECT_LT(log, last) << at;
    last = log;
  }
  EXPECT_NEAR(last, -0.5 * 90.0 * 90.0 / 0.02, 10.0);  // the difference has the variance of both
}

TEST(PartOfFirst, OfEachSizeOfTheGridAsOfOne) {
  Eigen::Matrix3d products;  // the third column is beside the two
  products << 50.0, 20.0, 5.0, 20.0, 40.0, 8.0, 5.0, 8.0, 30.0;
  const Eigen::Vector3d target(90.0, 70.0, 20.0);
  const double rest = 400.0, freedoms = 100.0;
  const Sizes logs = logPartOfFirst(products, target, rest, freedoms);
  for (const int s : {0, kSizes / 2, kSizes - 1}) {
    const double square = sizeGrid()[s] * sizeGrid()[s];
    const Eigen::Matrix3d covariance = (products + Eigen::Matrix3d::Identity() / square).inverse();
    const Eigen::Vector3d mean = covariance * target;
    const double variance = (rest - mean.dot(target)) / freedoms;
    const double expected = logPartOfFirst(Eigen::Vector2d(mean.head<2>()),
                                           Eigen::Matrix2d(variance * covariance.topLeftCorner<2, 2>()));
    EXPECT_NEAR(logs[s], expected, 1e-6) << s;
  }
}

}  // namespace
}  // namespace mm
