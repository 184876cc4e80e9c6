#include "thermal/mutual_information.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/error.h"
#include "random_numbers.h"

namespace mm {
namespace {

using test_support::RandomNumbers;

/// Displacement correlated by rho with sensor 0; sensor 1 says nothing.
struct Gaussian {
  Eigen::MatrixXd t;
  Eigen::VectorXd y;
  Gaussian(int n, double rho, std::uint64_t seed) : t(n, 2), y(n) {
    RandomNumbers random(seed);
    for (int i = 0; i < n; ++i) {
      t(i, 0) = random.normal(1.0);
      t(i, 1) = random.normal(1.0);
      y(i) = rho * t(i, 0) + std::sqrt(1.0 - rho * rho) * random.normal(1.0);
    }
  }
};

double information(const Gaussian& g, const std::vector<int>& sensors, InformationSettings settings = {}) {
  return SensorInformation(g.t, g.y, settings).joint(sensors);
}

TEST(Ksg, FindsTheInformationOfNormalQuantities) {
  for (double rho : {0.3, 0.6, 0.9, 0.99}) {
    const double truth = -0.5 * std::log(1.0 - rho * rho);
    double mean = 0.0;
    for (int seed = 0; seed < 10; ++seed)
      mean += information({300, rho, 10u + static_cast<unsigned>(seed)}, {0}) / 10.0;
    EXPECT_NEAR(mean, truth, 0.06) << "rho " << rho;
  }
}

TEST(Ksg, AnIndependentSensorHasNone) {
  double mean = 0.0;
  for (unsigned seed = 0; seed < 20; ++seed) mean += information({100, 0.9, seed}, {1}) / 20.0;
  EXPECT_NEAR(mean, 0.0, 0.03);
}

TEST(Ksg, SeesWhatCorrelationDoesNot) {
  RandomNumbers random(3);
  Eigen::MatrixXd t(200, 1);
  Eigen::VectorXd y(200);
  for (int i = 0; i < 200; ++i) {
    t(i, 0) = random.uniform(-1.0, 1.0);
    y(i) = t(i, 0) * t(i, 0);
  }
  const SensorInformation ksg(t, y, {});
  EXPECT_LT(ksg.correlation(0), 0.2);
  EXPECT_GT(ksg.joint({0}), 1.5);
}

TEST(Ksg, DoesNotDependOnUnits) {
  Gaussian g(100, 0.8, 5);
  const double before = information(g, {0, 1});
  g.t.col(0) = g.t.col(0).array() * 1.8 + 32.0;
  g.y *= 1e-6;
  EXPECT_NEAR(information(g, {0, 1}), before, 1e-6);
}

TEST(Ksg, TiesDoNotBreakIt) {
  Gaussian g(100, 0.9, 6);
  g.t = (g.t * 2.0).array().round() / 2.0;
  const double value = information(g, {0});
  EXPECT_TRUE(std::isfinite(value));
  EXPECT_GT(value, 0.3);
  EXPECT_EQ(value, information(g, {0}));
}

TEST(Histogram, CountsCellsAsPrinted) {
  // Four samples, two bins each; p(low, low) = p(high, high) = 1/2, so I = log 2.
  Eigen::MatrixXd t(4, 1);
  t << 0, 0, 1, 1;
  Eigen::VectorXd y(4);
  y << 5, 5, 9, 9;
  InformationSettings settings;
  settings.estimator = InformationEstimator::kHistogram;
  settings.temperatureBins = settings.displacementBins = 2;
  EXPECT_NEAR(SensorInformation(t, y, settings).joint({0}), std::log(2.0), 1e-12);
  // Three of four in one cell: 3/4, 1/4 with T equal to Y: I = H(1/4).
  t << 0, 0, 0, 1;
  y << 5, 5, 5, 9;
  EXPECT_NEAR(SensorInformation(t, y, settings).joint({0}), -0.75 * std::log(0.75) - 0.25 * std::log(0.25),
              1e-12);
  // Miller-Madow: two cells of each, two of both: + (2 + 2 - 2 - 1) / (2 * 4).
  settings.correction = BiasCorrection::kMillerMadow;
  EXPECT_NEAR(SensorInformation(t, y, settings).joint({0}),
              -0.75 * std::log(0.75) - 0.25 * std::log(0.25) + 1.0 / 8.0, 1e-12);
}

TEST(Histogram, CommonRangeHidesASensorThatMovesLittle) {
  Gaussian g(200, 0.95, 7);
  g.t.col(0) *= 0.01;
  InformationSettings settings;
  settings.estimator = InformationEstimator::kHistogram;
  EXPECT_LT(information(g, {0}, settings), 0.1);
  settings.commonRange = false;
  EXPECT_GT(information(g, {0}, settings), 0.8);
}

TEST(Histogram, ShuffleTakesMostOfTheBias) {
  InformationSettings settings;
  settings.estimator = InformationEstimator::kHistogram;
  const Gaussian g(100, 0.0, 8);
  EXPECT_GT(information(g, {0}, settings), 1.0);
  settings.correction = BiasCorrection::kMillerMadow;
  EXPECT_GT(information(g, {0}, settings), 0.3);
  settings.correction = BiasCorrection::kShuffle;
  EXPECT_NEAR(information(g, {0}, settings), 0.0, 0.15);
  settings.correction = BiasCorrection::kCircularShift;
  EXPECT_NEAR(information(g, {0}, settings), 0.0, 0.15);
}

TEST(Correlation, IsTheInformationOfTheMultipleCorrelation) {
  InformationSettings settings;
  settings.estimator = InformationEstimator::kCorrelation;
  EXPECT_NEAR(information({20000, 0.8, 9}, {0, 1}, settings), -0.5 * std::log(1.0 - 0.64), 0.02);
}

TEST(Information, RefusesBadSeries) {
  Gaussian g(20, 0.5, 1);
  EXPECT_THROW(SensorInformation(g.t, g.y.head(19), {}), InputError);
  EXPECT_THROW(SensorInformation(g.t.topRows(1), g.y.head(1), {}), InputError);
  g.t(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(SensorInformation(g.t, g.y, {}), InputError);
  InformationSettings settings;
  settings.temperatureBins = 0;
  EXPECT_THROW(SensorInformation(Gaussian(20, 0.5, 1).t, g.y, settings), InputError);
}

}  // namespace
}  // namespace mm
