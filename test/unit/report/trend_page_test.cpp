// What is said of parameters over time.
#include "report/trend_page.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

ParameterTrend trendOf(double slope) {
  ParameterTrend t;
  t.effect = EffectSpec("scale").set("axis", "x");
  t.name = "scale";
  t.unit = "um/m";
  t.points.resize(3);
  t.slope = slope;
  t.slopeStd = slope;
  return t;
}

// Calibrations of one moment may differ by any amount: that is no steady machine.
TEST(TrendPage, WithoutATimeBetweenNothingIsSteady) {
  const std::string unknown = trendSentence({trendOf(std::nan("")), trendOf(std::nan(""))});
  EXPECT_EQ(unknown.rfind("No trend can be determined", 0), 0u) << unknown;
  EXPECT_NE(unknown.find("--compare"), std::string::npos) << unknown;
  EXPECT_EQ(trendSentence({trendOf(0.1), trendOf(std::nan(""))}),
            "None of 2 parameters has a significant trend over 3 calibrations.");
}

// How much sessions scatter cannot be told from two.
TEST(TrendPage, TwoCalibrationsAreComparedAndMakeNoTrend) {
  ParameterTrend two = trendOf(0.1);
  two.points.resize(2);
  EXPECT_EQ(trendSentence({two}),
            "Two calibrations are stored: a trend needs three; compare these with --compare.");
}

}  // namespace
}  // namespace mm
