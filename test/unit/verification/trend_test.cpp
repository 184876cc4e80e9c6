#include "verification/trend.h"

#include <gtest/gtest.h>

#include <cmath>

#include "compensation_support.h"
#include "verification/calibration_changes.h"

namespace mm {
namespace {

/// A scale of x, um/m, known to 1 um/m, of that day.
Calibration calibrated(int day, double scale) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  c.id = "day" + std::to_string(day);
  c.created = "2026-03-" + std::string(day < 10 ? "0" : "") + std::to_string(day) + "T00:00:00Z";
  c.values[0].value = scale * 1e-6;
  c.values[0].std = 1e-6;
  c.covariance(0, 0) = 1e-12;
  return c;
}

TEST(Trend, isTheWeightedLine) {
  // 10 um/m in 10 days; the slope's standard deviation is 1 / sqrt(sum of (day - mean)^2) = 1 / sqrt(50).
  const std::vector<ParameterTrend> trends =
      trendsOf({calibrated(1, 50.0), calibrated(6, 55.0), calibrated(11, 60.0)});
  ASSERT_EQ(trends.size(), 1u);
  EXPECT_NEAR(trends[0].slope, 1.0, 1e-9);
  EXPECT_NEAR(trends[0].slopeStd, 1.0 / std::sqrt(50.0), 1e-9);
  EXPECT_NEAR(trends[0].change, 10.0, 1e-9);
  // t = 7 with one degree of freedom: three sessions do not tell how much sessions scatter
  EXPECT_NEAR(trends[0].pValue, 1.0 - 2.0 / M_PI * std::atan(std::sqrt(50.0)), 1e-9);
  EXPECT_FALSE(trends[0].significant);
}

TEST(Trend, ofTwoSessionsIsNotJudged) {
  const std::vector<ParameterTrend> trends = trendsOf({calibrated(1, 50.0), calibrated(11, 90.0)});
  EXPECT_NEAR(trends[0].slope, 4.0, 1e-9);
  EXPECT_NEAR(trends[0].slopeStd, std::sqrt(2.0) / 10.0, 1e-9);
  EXPECT_EQ(trends[0].pValue, 1.0);
  EXPECT_FALSE(trends[0].significant);
}

TEST(Trend, ofSixSessionsThatGoOneWayIsSignificant) {
  std::vector<Calibration> calibrations;
  for (int k = 0; k < 6; ++k) calibrations.push_back(calibrated(1 + 4 * k, 50.0 + 12.0 * k));
  const std::vector<ParameterTrend> trends = trendsOf(calibrations);
  EXPECT_TRUE(trends[0].significant);
  EXPECT_LT(trends[0].pValue, 1e-6);
  EXPECT_NE(trends[0].inWords.find("in 30 days"), std::string::npos) << trends[0].inWords;
}

TEST(Trend, ofAStepSaysWhenAndByHowMuch) {
  std::vector<Calibration> calibrations;
  for (int k = 0; k < 8; ++k) calibrations.push_back(calibrated(1 + 3 * k, (k < 4 ? 50.0 : 90.0) + k % 2));
  const std::vector<ParameterTrend> trends = trendsOf(calibrations);
  EXPECT_TRUE(trends[0].significant);
  EXPECT_NE(trends[0].inWords.find("changed by 40.0 ± 1.4 um/m (k = 2) between 2026-03-10 and 2026-03-13"),
            std::string::npos)
      << trends[0].inWords;
}

TEST(DaysOf, countsFrom1970) {
  EXPECT_DOUBLE_EQ(daysOf("1970-01-01T00:00:00Z"), 0.0);
  EXPECT_DOUBLE_EQ(daysOf("2024-02-29T12:00:00Z"), 19782.5);
  EXPECT_DOUBLE_EQ(daysOf("2024-02-29"), 19782.0);
  EXPECT_TRUE(std::isnan(daysOf("")));
}

TEST(Trend, ofPointsThatScatterMoreThanTheySayIsLessCertain) {
  const std::vector<ParameterTrend> trends =
      trendsOf({calibrated(1, 50.0), calibrated(6, 56.0), calibrated(11, 50.0)});
  ASSERT_EQ(trends.size(), 1u);
  EXPECT_NEAR(trends[0].slope, 0.0, 1e-9);
  EXPECT_NEAR(trends[0].slopeStd, std::sqrt(24.0 / 50.0), 1e-9);  // -2, 4, -2: chi squared 24
  EXPECT_FALSE(trends[0].significant);
}

TEST(Trend, ofFewPointsThatScatterIsJudgedByStudent) {
  // Residuals of the line -1, 2, -1: chi squared 6, one freedom; t = 2 / sqrt(6 / 50) has Cauchy's
  // distribution.
  const std::vector<ParameterTrend> trends =
      trendsOf({calibrated(1, 49.0), calibrated(6, 62.0), calibrated(11, 69.0)});
  ASSERT_EQ(trends.size(), 1u);
  const double slope = 2.0, std = std::sqrt(6.0 / 50.0);
  EXPECT_NEAR(trends[0].slope, slope, 1e-9);
  EXPECT_NEAR(trends[0].pValue, 1.0 - 2.0 / M_PI * std::atan(slope / std), 1e-9);  // 0.11, not 1e-8
  EXPECT_FALSE(trends[0].significant);
}

TEST(Trend, ofLessThanADayHasNoRate) {
  // 60 um/m more in an hour, as a machine warms up, are no 43,000 in 30 days.
  std::vector<Calibration> hour, day;
  for (int k = 0; k < 6; ++k) {
    hour.push_back(calibrated(1, 50.0 + 12.0 * k));
    hour.back().created = "2026-03-01T00:" + std::to_string(10 + 8 * k) + ":00Z";
    day.push_back(hour.back());
  }
  day.back().created = "2026-03-02T00:10:00Z";
  const std::vector<ParameterTrend> within = trendsOf(hour), over = trendsOf(day);
  EXPECT_TRUE(std::isnan(within[0].slope)) << within[0].inWords;
  EXPECT_EQ(within[0].pValue, 1.0);
  EXPECT_FALSE(within[0].significant);
  EXPECT_EQ(within[0].inWords.find("in 30 days"), std::string::npos) << within[0].inWords;
  EXPECT_NEAR(within[0].change, 60.0, 1e-9);
  EXPECT_TRUE(std::isfinite(over[0].slope)) << over[0].inWords;
}

TEST(Trend, ofOneSessionTakesTheLastCalibration) {
  Calibration first = calibrated(1, 50.0), again = calibrated(2, 52.0), later = calibrated(11, 60.0);
  first.sessionHash = again.sessionHash = "a";
  later.sessionHash = "b";
  const std::vector<ParameterTrend> trends = trendsOf({first, again, later});
  ASSERT_EQ(trends.size(), 1u);
  ASSERT_EQ(trends[0].points.size(), 2u);
  EXPECT_EQ(trends[0].points[0].id, "day2");
  EXPECT_EQ(refitted({first, again, later}), std::vector<std::string>{"day1"});
}

TEST(Trend, goesByTheTimeOfTheMeasurement) {
  // Calibrated late and in another order; an imported session has no date of its own.
  Calibration march = calibrated(20, 60.0), february = calibrated(21, 50.0), imported = calibrated(22, 62.0);
  constexpr double kDay = 86400.0;
  february.sessionEpoch = daysOf("2026-02-01T00:00:00Z") * kDay;
  march.sessionEpoch = daysOf("2026-03-01T00:00:00Z") * kDay;
  imported.sessionEpoch = 1e9;
  const std::vector<ParameterTrend> trends = trendsOf({march, february, imported});
  ASSERT_EQ(trends[0].points.size(), 3u);
  EXPECT_EQ(trends[0].points[0].id, "day21");
  EXPECT_NEAR(trends[0].points[1].day, 28.0, 1e-9);
  EXPECT_EQ(trends[0].points[1].measured, "2026-03-01T00:00:00Z");
  EXPECT_NEAR(trends[0].points[2].day, 49.0, 1e-9);
  EXPECT_EQ(trends[0].points[2].measured, "2026-03-22T00:00:00Z");
}

TEST(CalibrationChanges, ofOneSessionAreNotJudged) {
  Calibration first = calibrated(1, 50.0), again = calibrated(2, 60.0);
  first.sessionHash = again.sessionHash = "a";
  const CalibrationChanges changes = changesBetween(first, again);
  ASSERT_EQ(changes.parameters.size(), 1u);
  EXPECT_TRUE(std::isnan(changes.parameters[0].pValue));
  EXPECT_FALSE(changes.parameters[0].significant);
  EXPECT_EQ(changes.inWords.find("both are from the same session"), 0u) << changes.inWords;
}

TEST(CalibrationChanges, areJudgedByBothUncertainties) {
  const CalibrationChanges same = changesBetween(calibrated(1, 50.0), calibrated(2, 52.0));
  ASSERT_EQ(same.parameters.size(), 1u);
  EXPECT_NEAR(same.parameters[0].std, std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(same.parameters[0].pValue, std::erfc(1.0), 1e-9);  // 2 / sqrt(2) standard deviations
  EXPECT_FALSE(same.parameters[0].significant);
  const CalibrationChanges other = changesBetween(calibrated(1, 50.0), calibrated(2, 60.0));
  EXPECT_TRUE(other.parameters[0].significant);
  EXPECT_NEAR(other.largest, 0.2e-6, 1e-9);  // 10 um/m at 20 mm
}

}  // namespace
}  // namespace mm
