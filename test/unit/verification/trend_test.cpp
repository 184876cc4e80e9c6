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
  EXPECT_TRUE(trends[0].significant);
}

TEST(Trend, ofPointsThatScatterMoreThanTheySayIsLessCertain) {
  const std::vector<ParameterTrend> trends =
      trendsOf({calibrated(1, 50.0), calibrated(6, 56.0), calibrated(11, 50.0)});
  ASSERT_EQ(trends.size(), 1u);
  EXPECT_NEAR(trends[0].slope, 0.0, 1e-9);
  EXPECT_NEAR(trends[0].slopeStd, std::sqrt(24.0 / 50.0), 1e-9);  // -2, 4, -2: chi squared 24
  EXPECT_FALSE(trends[0].significant);
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
