#include "model/smoothed_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/random.h"

namespace mm {
namespace {

constexpr int kReadings = 400;

/// degC: a day of a workshop, an hour of it measured.
double course(double t) { return 20.0 + 1.5 * (1.0 - std::exp(-t / 1200.0)) + 0.2 * std::sin(t / 500.0); }

Series read(double (*of)(double), double noise, double step) {
  Random random(7, "thermometer");
  Series s{"bed", "degC", {}, {}};
  for (int i = 0; i < kReadings; ++i) {
    const double t = 9.0 * i, value = of(t) + noise * random.normal();
    s.time.push_back(t);
    s.value.push_back(step > 0.0 ? step * std::round(value / step) : value);
  }
  return s;
}

double rmsAgainst(double (*of)(double), const Series& s) {
  double sum = 0.0;
  for (std::size_t i = 0; i < s.time.size(); ++i) sum += std::pow(s.value[i] - of(s.time[i]), 2);
  return std::sqrt(sum / static_cast<double>(s.time.size()));
}

TEST(SmoothedSeries, LosesMostOfWhatScatters) {
  const Series raw = read(course, 0.08, 0.0);
  EXPECT_GT(rmsAgainst(course, raw), 0.07);
  EXPECT_LT(rmsAgainst(course, smoothed(raw)), 0.02);
}

TEST(SmoothedSeries, SeesBetweenTheStepsOfAThermometerThatRounds) {
  const Series raw = read(course, 0.03, 0.1);
  EXPECT_LT(rmsAgainst(course, smoothed(raw)), 0.4 * rmsAgainst(course, raw));
}

TEST(SmoothedSeries, LeavesWhatDoesNotScatter) {
  const Series raw = read(course, 0.0, 0.0);
  EXPECT_LT(rmsAgainst(course, smoothed(raw)), 1e-4);
}

TEST(SmoothedSeries, AStepIsFeltByItsNeighboursAlone) {
  const auto door = [](double t) { return t < 1800.0 ? 20.0 : 22.0; };
  const Series course = smoothed(read(+door, 0.02, 0.0));
  for (std::size_t i = 0; i < course.time.size(); ++i)
    if (std::abs(course.time[i] - 1800.0) > 5 * 9.0) {
      EXPECT_NEAR(course.value[i], door(course.time[i]), 0.1) << course.time[i] << " s";
    }
}

TEST(SmoothedSeries, PassesOverWhatIsNotKnown) {
  Series raw = read(course, 0.08, 0.0);
  raw.value[100] = std::numeric_limits<double>::quiet_NaN();
  const Series course = smoothed(raw);
  EXPECT_TRUE(std::isnan(course.value[100]));
  EXPECT_TRUE(std::isfinite(course.value[99]));
  const Series few{"bed", "degC", {0.0, 1.0, 2.0}, {20.0, 20.1, 19.9}};
  EXPECT_EQ(smoothed(few).value, few.value);
  EXPECT_TRUE(smoothed(Series{}).value.empty());
}

TEST(SmoothedSeries, ManyReadingsOfOneMomentAreOneMoreCertain) {
  Series raw;
  Random random(3, "thermometer");
  for (int i = 0; i < 60; ++i)
    for (int again = 0; again < 5; ++again) {
      raw.time.push_back(60.0 * i);
      raw.value.push_back(course(60.0 * i) + 0.1 * random.normal());
    }
  EXPECT_LT(rmsAgainst(course, smoothed(raw)), 0.04);
}

}  // namespace
}  // namespace mm
