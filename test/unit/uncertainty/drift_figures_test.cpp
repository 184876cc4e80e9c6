#include "uncertainty/drift_figures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "long_tests.h"

namespace mm {
namespace {

// Every half hour, um; the heating goes from 0.5 h (after the reading 1) to 2.5 h (the reading 15):
//   h      0   0.5  1.0  1.5  2.0  2.5  3.0  3.5
//   um     0    1    5    9   13   15   11    9
//   range 15 - 0 = 15;  within an hour 9 - 1 = 13 - 5 = 8 (0.5 … 1.5, 1.0 … 2.0);  first hour 9 - 1 = 8
//   heated 15 - 1 = 14;  recovery 9 - 15 = -6
TEST(DriftFigures, WorkedByHand) {
  const DriftCurve curve{{0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5}, {0, 1, 5, 9, 13, 15, 11, 9}};
  const DriftFigures f = driftFigures(curve, {0.5, 2.5}, kNotMeasured);
  EXPECT_DOUBLE_EQ(f.range.value, 15.0);
  EXPECT_DOUBLE_EQ(f.hour.value, 8.0);
  EXPECT_DOUBLE_EQ(f.firstHour.value, 8.0);
  EXPECT_DOUBLE_EQ(f.heated.value, 14.0);
  EXPECT_DOUBLE_EQ(f.recovery.value, -6.0);
  EXPECT_TRUE(std::isnan(f.range.std));  // the noise is not known
}

TEST(DriftFigures, BetweenReadingsLinearAndNothingOfAShortTest) {
  // heated from 0.25 h: value 5; an hour later, at 1.25 h: 25
  const DriftCurve curve{{0.0, 0.5, 1.0, 1.5}, {0, 10, 20, 30}};
  EXPECT_DOUBLE_EQ(driftFigures(curve, {0.25, 1.5}, kNotMeasured).firstHour.value, 20.0);
  const DriftFigures brief = driftFigures({{0.0, 0.2, 0.4}, {0, 3, 1}}, {0.0, 0.2}, kNotMeasured);
  EXPECT_DOUBLE_EQ(brief.range.value, 3.0);
  EXPECT_DOUBLE_EQ(brief.recovery.value, -2.0);
  EXPECT_TRUE(std::isnan(brief.hour.value));
  EXPECT_TRUE(std::isnan(brief.firstHour.value));
}

TEST(DriftFigures, NoiseOfADifferenceAndOfARange) {
  // Ten readings of nothing but noise of 1 um: their range is 3.078 um on average (d2 of ten, ISO 7870-2),
  // the difference of two has a standard deviation of sqrt(2) um and no bias.
  DriftCurve curve;
  for (int i = 0; i < 10; ++i) {
    curve.hours.push_back(0.25 * i);
    curve.value.push_back(0.0);
  }
  const DriftFigures f = driftFigures(curve, {0.0, 2.0}, 1.0);
  EXPECT_NEAR(f.range.noise, 3.078, 0.15);
  EXPECT_NEAR(f.range.std, 0.797, 0.08);  // d3 of ten
  EXPECT_NEAR(f.heated.noise, 0.0, 1e-9);
  EXPECT_NEAR(f.heated.std, std::sqrt(2.0), 0.12);
}

TEST(DriftFigures, ReadingsThatAreMissingDoNotCount) {
  const DriftFigures f =
      driftFigures({{0.0, 0.5, 1.0, 1.5}, {0, 4, kNotMeasured, 6}}, {0.0, 1.5}, kNotMeasured);
  EXPECT_DOUBLE_EQ(f.range.value, 6.0);
  EXPECT_DOUBLE_EQ(f.firstHour.value, 5.0);  // half way between 4 and 6
}

/// A machine that warms with a time constant for four hours and cools with another for two: A (1 -
/// e^(-t/tau)).
class WarmUp : public ::testing::Test {
 protected:
  static constexpr double kAmplitude = 20.0, kTau = 0.9, kCooling = 1.4, kStop = 4.0, kNoise = 0.5;

  static double truth(double hour) {
    if (hour <= kStop) return kAmplitude * (1.0 - std::exp(-hour / kTau));
    return kAmplitude * (1.0 - std::exp(-kStop / kTau)) * std::exp(-(hour - kStop) / kCooling);
  }
  static DriftCurve drawn(std::mt19937& generator) {
    std::normal_distribution<double> noise(0.0, kNoise);
    DriftCurve curve;
    for (int i = 0; i <= 72; ++i) {
      curve.hours.push_back(i / 12.0);
      curve.value.push_back(truth(i / 12.0) + noise(generator));
    }
    return curve;
  }
};

TEST_F(WarmUp, FiguresAreWithinTheirUncertainties) {
  std::mt19937 generator(11);
  const double top = truth(kStop), end = truth(6.0);
  const double steepest = truth(1.0);  // of all hours the first: it rises most
  int inRange = 0, inHour = 0, inFirst = 0, inHeated = 0, inRecovery = 0;
  constexpr int kDraws = 200;
  const auto within = [](const DriftFigure& f, double truth) {
    return std::abs(f.value - f.noise - truth) <= 2.0 * f.std;
  };
  for (int draw = 0; draw < kDraws; ++draw) {
    const DriftFigures f = driftFigures(drawn(generator), {0.0, kStop}, kNoise);
    inRange += within(f.range, top);
    inHour += within(f.hour, steepest);
    inFirst += within(f.firstHour, truth(1.0));
    inHeated += within(f.heated, top);
    inRecovery += within(f.recovery, end - top);
  }
  // 95 % of 200 are 190, with a standard deviation of 3.1
  EXPECT_GE(inRange, 180);
  EXPECT_GE(inHour, 180);
  EXPECT_GE(inFirst, 181);
  EXPECT_GE(inHeated, 181);
  EXPECT_GE(inRecovery, 181);
}

// Where the end of the heating is taken from the readings, it is taken where their noise is largest: a
// machine that does not move at all must not be said to.
TEST(DriftFigures, AChosenEndOfTheHeatingIsPartOfTheUncertainty) {
  std::mt19937 generator(3);
  std::normal_distribution<double> noise(0.0, 1.0);
  const int draws = mm_test::thoroughTests() ? 1000 : 250;
  int within = 0;
  for (int draw = 0; draw < draws; ++draw) {
    DriftCurve curve;
    for (int i = 0; i <= 60; ++i) {
      curve.hours.push_back(i / 12.0);
      curve.value.push_back(noise(generator));
    }
    const DriftFigure f = driftFigures(curve, heatedTime(curve), 1.0).heated;
    within += std::abs(f.value) <= 2.0 * f.std;
  }
  EXPECT_GE(within, mm_test::thoroughTests() ? 929 : 227) << "95 %, less three standard deviations";
}

TEST_F(WarmUp, EndOfTheHeatingIsFoundWhereNothingTells) {
  std::mt19937 generator(5);
  for (int draw = 0; draw < 50; ++draw) {
    const HeatedTime heated = heatedTime(drawn(generator));
    EXPECT_DOUBLE_EQ(heated.from, 0.0);
    EXPECT_NEAR(truth(heated.to), truth(kStop), 1.5);  // on the flat top, which is long
    EXPECT_LT(heated.to, 4.3);
  }
}

}  // namespace
}  // namespace mm
