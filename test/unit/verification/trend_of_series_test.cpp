#include "verification/trend_of_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "long_tests.h"

namespace mm {
namespace {

/// A series with stated noise and a scatter from session to session.
std::vector<TrendPoint> series(std::mt19937_64& random, std::size_t count, double stated, double scatter) {
  std::normal_distribution<double> normal;
  std::vector<TrendPoint> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back(
        {18.0 * static_cast<double>(i), 5.0 + std::hypot(stated, scatter) * normal(random), stated});
  return points;
}

TEST(TrendOfSeries, quietSeriesRaiseNoMoreAlarmsThanIsAccepted) {
  std::mt19937_64 random(7);
  constexpr int kSeries = 4000;
  for (const double scatter : {0.0, 0.2}) {
    for (const std::size_t count : {6u, 12u, 40u}) {
      int alarms = 0;
      for (int i = 0; i < kSeries; ++i)
        alarms += trendOf(series(random, count, scatter > 0.0 ? 0.05 : 0.1, scatter), 0.05).kind !=
                  Trend::Kind::kQuiet;
      // binomial: 0.05 of 4000 is 200 +- 14
      EXPECT_LE(alarms, 242) << count << " points, scatter " << scatter;
    }
  }
}

TEST(TrendOfSeries, valuesWithoutStatedUncertaintyRaiseNoMoreEither) {
  std::mt19937_64 random(8);
  int alarms = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<TrendPoint> points = series(random, 12, 0.0, 0.3);
    alarms += trendOf(points, 0.05).kind != Trend::Kind::kQuiet;
  }
  EXPECT_LE(alarms, 242);
}

TEST(TrendOfSeries, aStepIsFoundWhereItIsWithItsLevels) {
  std::mt19937_64 random(9);
  std::vector<TrendPoint> points = series(random, 30, 0.1, 0.05);
  for (std::size_t i = 18; i < points.size(); ++i) points[i].value += 1.0;
  const Trend trend = trendOf(points, 1e-5);
  ASSERT_EQ(trend.kind, Trend::Kind::kSteps);
  ASSERT_EQ(trend.segments.size(), 2u);
  EXPECT_EQ(trend.segments[1].first, 18u);
  EXPECT_NEAR(trend.segments[1].level - trend.segments[0].level, 1.0,
              4 * 0.112 * std::sqrt(1.0 / 18 + 1.0 / 12));
  EXPECT_LT(trend.stepP[0], 1e-5);
}

TEST(TrendOfSeries, wearThatGrowsIsADriftAndNoStep) {
  std::mt19937_64 random(10);
  std::vector<TrendPoint> points = series(random, 30, 0.1, 0.05);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].value += 1.5 * static_cast<double>(i) / 29.0;
  const Trend trend = trendOf(points, 1e-5);
  ASSERT_EQ(trend.kind, Trend::Kind::kDrift);
  EXPECT_NEAR(trend.end - trend.start, 1.5, 0.2);
  EXPECT_NEAR(trend.slope * (points.back().day - points.front().day), trend.end - trend.start, 1e-12);
}

TEST(TrendOfSeries, whatIsRepairedAndReturnsIsThreeLevels) {
  std::mt19937_64 random(11);
  std::vector<TrendPoint> points = series(random, 36, 0.1, 0.0);
  for (std::size_t i = 12; i < 24; ++i) points[i].value -= 2.0;
  const Trend trend = trendOf(points, 1e-5);
  ASSERT_EQ(trend.segments.size(), 3u);
  EXPECT_EQ(trend.segments[1].first, 12u);
  EXPECT_EQ(trend.segments[2].first, 24u);
}

TEST(TrendOfSeries, oneBadSessionIsNoChange) {
  std::mt19937_64 random(12);
  for (const std::size_t bad : {0u, 1u, 15u, 28u, 29u}) {
    std::vector<TrendPoint> points = series(random, 30, 0.1, 0.0);
    points[bad].value += 3.0;
    EXPECT_EQ(trendOf(points, 1e-5).kind, Trend::Kind::kQuiet) << bad;
  }
}

TEST(TrendOfSeries, shortAndConstantSeriesAreQuiet) {
  EXPECT_EQ(trendOf({}, 0.05).kind, Trend::Kind::kQuiet);
  EXPECT_EQ(trendOf({{0, 1, 0.1}}, 0.05).segments.size(), 1u);
  std::vector<TrendPoint> same(20, {0.0, 3.0, 0.0});
  for (std::size_t i = 0; i < same.size(); ++i) same[i].day = static_cast<double>(i);
  const Trend trend = trendOf(same, 0.05);
  EXPECT_EQ(trend.kind, Trend::Kind::kQuiet);
  EXPECT_DOUBLE_EQ(trend.segments[0].level, 3.0);
}

/// Alarms of series in which nothing happens, at the level `alpha`.
int alarmsOf(std::mt19937_64& random, int seriesCount, std::size_t points, double scatter, double spread,
             double alpha) {
  std::normal_distribution<double> normal;
  int alarms = 0;
  for (int i = 0; i < seriesCount; ++i) {
    std::vector<TrendPoint> quiet;
    for (std::size_t k = 0; k < points; ++k) {
      const double std = 0.1 * std::exp(spread * normal(random));
      quiet.push_back({30.0 * static_cast<double>(k), 2.0 + std::hypot(std, scatter) * normal(random), std});
    }
    alarms += trendOf(quiet, alpha).kind != Trend::Kind::kQuiet;
  }
  return alarms;
}

// Stated 0.1: the true scatter is none, as large as stated, and 3 and 30 times as large.
TEST(TrendOfSeries, aScatterThatIsNotStatedRaisesNoMoreAlarms) {
  std::mt19937_64 random(31);
  const int count = mm_test::thoroughTests() ? 40000 : 2000;
  for (const double alpha : {0.05, 0.01})
    for (const std::size_t points : {5u, 6u, 12u})
      for (const double scatter : {0.0, 0.1, 0.3, 3.0})
        for (const double spread : {0.0, 0.3}) {
          const double expected = alpha * count;
          EXPECT_LE(alarmsOf(random, count, points, scatter, spread, alpha),
                    1.05 * expected + 3.5 * std::sqrt(expected))
              << alpha << ", " << points << " points, scatter " << scatter << ", spread " << spread;
        }
}

/// A gap in um that grows from 0.94 to 5.99, 5.99 +- 0.15 (k = 2), in six months.
std::vector<TrendPoint> wear(double noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<TrendPoint> points;
  for (int i = 0; i < 6; ++i) points.push_back({30.4 * i, 0.94 + 1.01 * i + noise * normal(random), 0.075});
  return points;
}

TEST(TrendOfSeries, aGapThatGrowsInSixSessionsIsFoundBeyondDoubt) {
  std::mt19937_64 random(32);
  const Trend exact = trendOf(wear(0.0, random), 1e-3);
  EXPECT_EQ(exact.kind, Trend::Kind::kDrift);
  EXPECT_LT(exact.p, 1e-8);
  EXPECT_NEAR(exact.end - exact.start, 5.05, 1e-9);
  EXPECT_EQ(exact.scatter, 0.0);
  EXPECT_NEAR(exact.slopeStd, 0.075 / (30.4 * std::sqrt(17.5)), 1e-12);
  int sure = 0, drifts = 0;
  for (int i = 0; i < 200; ++i) {
    const Trend trend = trendOf(wear(0.075, random), 1e-3);
    sure += trend.p < 1e-6;
    drifts += trend.kind == Trend::Kind::kDrift;
  }
  EXPECT_GE(sure, 176);  // the others have residuals of twice what is stated
  EXPECT_EQ(drifts, 200);
}

TEST(TrendOfSeries, theScatterIsThatAboutTheDrift) {
  std::mt19937_64 random(33);
  std::vector<TrendPoint> points = series(random, 200, 0.1, 0.3);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].value += 0.05 * static_cast<double>(i);
  const Trend trend = trendOf(points, 1e-5);
  ASSERT_EQ(trend.kind, Trend::Kind::kDrift);
  EXPECT_NEAR(trend.scatter, 0.3, 0.05);
  EXPECT_NEAR(residualVariance(points), 10.0, 3.0);  // (0.01 + 0.09) / 0.01
}

TEST(TrendOfSeries, threePointsAreJudgedByStudentAlone) {
  // Residuals of the line -1, 2, -1: t = 2 / sqrt(6 / 50) has Cauchy's distribution.
  const Trend trend = trendOf({{0, 49.0, 1.0}, {5, 62.0, 1.0}, {10, 69.0, 1.0}}, 0.05);
  EXPECT_NEAR(trend.p, 1.0 - 2.0 / M_PI * std::atan(2.0 / std::sqrt(6.0 / 50.0)), 1e-9);
  EXPECT_EQ(trendOf({{0, 49.0, 1.0}, {5, 69.0, 1.0}}, 0.05).p, 1.0);
}

TEST(TrendOfSeries, oneSessionThatClaimsToBeExactHasNotAllTheWeight) {
  std::vector<TrendPoint> points;
  for (int i = 0; i < 8; ++i) points.push_back({30.0 * i, i % 2 == 0 ? 1.0 : -1.0, 1.0});
  points[0].std = points[7].std = 1e-3;  // 1 and -1: a drift, were the others ignored
  EXPECT_EQ(trendOf(points, 0.05).kind, Trend::Kind::kQuiet);
  EXPECT_GT(trendOf(points, 0.05).p, 0.2);
}

}  // namespace
}  // namespace mm
