#include "model/series_history.h"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

namespace mm {
namespace {

Series line(std::vector<double> time, std::vector<double> value) {
  return {"s", "degC", std::move(time), std::move(value)};
}

double at(const SeriesHistory& history, double tau, double time) {
  return history.lagged(0, tau, time, nullptr);
}

TEST(SeriesHistory, followsARampWithTheLagOfTheTextbook) {
  const SeriesHistory history({line({0, 100}, {20, 30})});
  const double tau = 12.0, slope = 0.1;
  for (const double t : {0.0, 1.0, 5.0, 40.0, 100.0})
    EXPECT_NEAR(at(history, tau, t), 20 + slope * (t - tau * (1 - std::exp(-t / tau))), 1e-12);
  // After the last value the temperature stays, and the lag catches up.
  const double behind = 30 - at(history, tau, 100);
  EXPECT_NEAR(at(history, tau, 100 + tau), 30 - behind * std::exp(-1.0), 1e-12);
  EXPECT_EQ(at(history, tau, -50), 20);
}

TEST(SeriesHistory, agreesWithSmallStepsOfTheDifferentialEquation) {
  const Series series = line({0, 10, 15, 40, 60, 61}, {20, 20, 35, 30, 30, 25});
  const SeriesHistory history({series});
  for (const double tau : {0.7, 8.0, 300.0}) {
    double y = 20.0;
    const double h = 1e-3;
    for (int i = 0; i < 80000; ++i) {  // midpoint rule
      const double t = i * h;
      const double half = y + 0.5 * h * (series.at(t) - y) / tau;
      y += h * (series.at(t + 0.5 * h) - half) / tau;
      if (i % 10000 != 9999) continue;
      EXPECT_NEAR(at(history, tau, t + h), y, 2e-5) << tau << " " << t;
    }
  }
}

TEST(SeriesHistory, givesTheDerivativeByTheTimeConstant) {
  const SeriesHistory history({line({0, 10, 15, 40, 60}, {20, 20, 35, 30, 31})});
  for (const double tau : {0.5, 8.0, 300.0})
    for (const double t : {5.0, 12.0, 30.0, 60.0, 200.0}) {
      double byTau = 0.0;
      history.lagged(0, tau, t, &byTau);
      const double h = 1e-4 * tau;
      EXPECT_NEAR(byTau, (at(history, tau + h, t) - at(history, tau - h, t)) / (2 * h), 1e-6)
          << tau << " " << t;
    }
}

TEST(SeriesHistory, hasLimitsOfMeaning) {
  const SeriesHistory history({line({0, 10}, {20, 30}), {}, line({5}, {22})});
  double byTau = 7.0;
  EXPECT_EQ(history.lagged(0, 0.0, 5.0, &byTau), 25.0);
  EXPECT_EQ(byTau, -1.0);
  EXPECT_NEAR(at(history, 1e-9, 5.0), 25.0, 1e-8);
  EXPECT_TRUE(std::isnan(history.lagged(1, 10.0, 5.0, &byTau)));
  EXPECT_TRUE(std::isnan(history.lagged(3, 10.0, 5.0, nullptr)));
  EXPECT_EQ(history.lagged(2, 10.0, 500.0, nullptr), 22.0);
}

TEST(SeriesHistory, takesTwoValuesAtOneStampAsAStep) {
  const SeriesHistory history({line({0, 10, 10, 20}, {20, 20, 30, 30})});
  EXPECT_NEAR(at(history, 5.0, 15.0), 30 - 10 * std::exp(-1.0), 1e-12);
}

TEST(SeriesHistory, answersThreadsAlike) {
  Series series = line({}, {});
  for (int i = 0; i < 500; ++i) {
    series.time.push_back(i);
    series.value.push_back(20 + std::sin(0.1 * i));
  }
  const SeriesHistory history({series});
  std::vector<double> sums(4, 0.0);
  std::vector<std::thread> threads;
  for (double& sum : sums)
    threads.emplace_back([&] {
      for (int tau = 1; tau < 60; ++tau)
        for (int t = 0; t < 500; t += 10) sum += history.lagged(0, tau, t, nullptr);
    });
  for (std::thread& thread : threads) thread.join();
  for (const double sum : sums) EXPECT_EQ(sum, sums.front());
}

}  // namespace
}  // namespace mm
