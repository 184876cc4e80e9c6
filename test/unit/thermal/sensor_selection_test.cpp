#include "thermal/sensor_selection.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numeric>

#include "base/error.h"
#include "long_tests.h"
#include "motor_spindle.h"
#include "random_numbers.h"
#include "spindle_simulation.h"
#include "thermal/ridge.h"
#include "thermal/series.h"

namespace mm {
namespace {

using namespace test_support;

/// Displacement made of sensors 2 and 5 of 8 slow, independent drifts.
struct Planted {
  Eigen::MatrixXd t;
  Eigen::VectorXd y;
  explicit Planted(int n = 120) : t(n, 8), y(n) {
    RandomNumbers random(4);
    for (int s = 0; s < 8; ++s) {
      const double period = random.uniform(20.0, 60.0), phase = random.uniform(0.0, 6.28);
      for (int i = 0; i < n; ++i)
        t(i, s) = 20.0 + 3.0 * std::sin(6.28 * i / period + phase) + random.normal(0.1);
    }
    for (int i = 0; i < n; ++i) y(i) = 4.0 * t(i, 2) - 3.0 * t(i, 5) + random.normal(0.3);
  }
};

TEST(SensorSelection, FindsThePlantedPairAndStopsThere) {
  const Planted planted;
  const SensorSelection selection = selectSensors(planted.t, planted.y);
  ASSERT_EQ(selection.sets.size(), 3u);
  EXPECT_EQ(selection.sets[1].sensors, (std::vector<int>{2, 5}));
  EXPECT_EQ(selection.recommended, 1u);
  EXPECT_NEAR(selection.sets[1].heldOutRms, 0.3, 0.06);
  EXPECT_EQ(selection.singles.size(), 8u);
  EXPECT_TRUE(selection.singles[0].sensor == 2 || selection.singles[0].sensor == 5);
  EXPECT_EQ(selection.subsetsTried, (std::vector<double>{8, 28, 56}));
}

TEST(SensorSelection, DoesNotDependOnThreads) {
  const Planted planted;
  SelectionSettings one, four;
  one.threads = 1;
  four.threads = 4;
  const SensorSelection a = selectSensors(planted.t, planted.y, one),
                        b = selectSensors(planted.t, planted.y, four);
  for (std::size_t m = 0; m < a.sets.size(); ++m) {
    EXPECT_EQ(a.sets[m].sensors, b.sets[m].sensors);
    EXPECT_EQ(a.sets[m].information, b.sets[m].information);
    EXPECT_EQ(a.sets[m].heldOutRms, b.sets[m].heldOutRms);
  }
}

TEST(SensorSelection, LeavesConstantSensorsOutAndNamesTwins) {
  Planted planted;
  planted.t.col(0).setConstant(21.5);
  planted.t.col(7) = planted.t.col(5).array() * 1.01 + 0.2;
  const SensorSelection selection = selectSensors(planted.t, planted.y);
  EXPECT_EQ(selection.constant, std::vector<int>{0});
  EXPECT_EQ(selection.singles.size(), 7u);
  const bool twins = std::any_of(selection.equivalent.begin(), selection.equivalent.end(), [](const auto& e) {
    return (e.first == 5 && e.second == std::vector<int>{7}) ||
           (e.first == 7 && e.second == std::vector<int>{5});
  });
  EXPECT_TRUE(twins);
}

TEST(SensorSelection, AsksTheSearchBeyondTheLimitAndReportsProgress) {
  const Planted planted;
  SelectionSettings settings;
  settings.enumerationLimit = 20;
  EXPECT_THROW(selectSensors(planted.t, planted.y, settings), InputError);
  int asked = 0;
  settings.search = [&](int sensors, int size, int, std::uint64_t, const SetScore& score,
                        const std::function<void(double)>& progress) {
    ++asked;
    EXPECT_EQ(sensors, 8);
    std::vector<int> subset(static_cast<std::size_t>(size));
    std::iota(subset.begin(), subset.end(), 0);
    score(subset);
    progress(0.5);
    return std::vector<std::vector<int>>{subset};
  };
  double last = 0.0;
  const SensorSelection selection =
      selectSensors(planted.t, planted.y, settings, [&](double f, const std::string&) {
        EXPECT_GE(f, last);
        last = f;
        return true;
      });
  EXPECT_EQ(asked, 2);
  EXPECT_EQ(last, 1.0);
  EXPECT_EQ(selection.exhaustive, (std::vector<bool>{true, false, false}));
  EXPECT_THROW(
      selectSensors(planted.t, planted.y, settings, [](double, const std::string&) { return false; }),
      Cancelled);
}

TEST(SensorSelection, RefusesWhatCannotBeChosenFrom) {
  const Planted planted;
  EXPECT_THROW(selectSensors(planted.t.topRows(1), planted.y.head(1)), InputError);
  EXPECT_THROW(selectSensors(planted.t, planted.y.head(50)), InputError);
  EXPECT_THROW(selectSensors(planted.t, Eigen::VectorXd::Constant(120, 3.0)), InputError);
  EXPECT_THROW(selectSensors(Eigen::MatrixXd::Constant(120, 3, 20.0), planted.y), InputError);
  Eigen::MatrixXd gap = planted.t;
  gap(5, 1) = std::nan("");
  EXPECT_THROW(selectSensors(gap, planted.y), InputError);
}

/// Least squares by normal equations, trained on one run and judged on others: nothing of the code under
/// test.
double judged(const SpindleRun& train, const std::vector<SpindleRun>& tests,
              const std::vector<int>& sensors) {
  const auto design = [&](const SpindleRun& run) {
    Eigen::MatrixXd x(run.temperatures.rows(), static_cast<Eigen::Index>(sensors.size()) + 1);
    x.col(0).setOnes();
    for (std::size_t s = 0; s < sensors.size(); ++s)
      x.col(static_cast<Eigen::Index>(s) + 1) = run.temperatures.col(sensors[s]).array() - 25.0;
    return x;
  };
  const Eigen::MatrixXd x = design(train);
  const Eigen::VectorXd w = (x.transpose() * x).eval().inverse() * (x.transpose() * train.displacement);
  double sum = 0.0;
  for (const SpindleRun& run : tests)
    sum += (design(run) * w - run.displacement).squaredNorm() / static_cast<double>(run.displacement.size());
  return std::sqrt(sum / static_cast<double>(tests.size()));
}

/// Geometric mean over the spindles of the error of what was picked over that of the best, of singles and
/// pairs.
struct Picks {
  double single = 0.0, pair = 0.0;
};

/// 20 spindles; at full length (MM_LONG_TESTS) 100, and beside the default what is published and what
/// information alone picks, for the table.
TEST(SensorSelection, PicksWellOnRandomSpindles) {
  const int spindles = mm_test::longTests() ? 100 : 20;
  struct Way {
    std::string name;
    SelectionSettings settings;
    Picks picks;
  };
  std::vector<Way> ways(1);
  ways[0].name = "other duties and held-out error (default)";
  if (mm_test::longTests()) {
    ways.resize(5);
    ways[1].name = "KSG, information alone";
    ways[2].name = "histogram as published, 30 bins";
    ways[2].settings.information.estimator = InformationEstimator::kHistogram;
    ways[3].name = "correlation";
    ways[3].settings.information.estimator = InformationEstimator::kCorrelation;
    for (std::size_t w = 1; w < 4; ++w) ways[w].settings.choice = SetChoice::kInformation;
    ways[4].name = "KSG, information and held-out error";
    ways[4].settings.choice = SetChoice::kHeldOut;
  }
  for (int k = 0; k < spindles; ++k) {
    const auto seed = 40000 + static_cast<std::uint64_t>(k);
    const RandomSpindle spindle(500 + seed);
    const SpindleRun train = spindle.run(patentDuty(), 100, 0.1, 0.5, 900 + seed);
    const std::vector<SpindleRun> tests{spindle.run(randomDuty(10 + 2 * seed), 100, 0.1, 0.0, 1),
                                        spindle.run(randomDuty(11 + 2 * seed), 100, 0.1, 0.0, 2)};
    double best[2] = {1e9, 1e9};
    for (int i = 0; i < 54; ++i) {
      best[0] = std::min(best[0], judged(train, tests, {i}));
      for (int j = i + 1; j < 54; ++j) best[1] = std::min(best[1], judged(train, tests, {i, j}));
    }
    for (Way& way : ways) {
      way.settings.largestSize = 2;
      const SensorSelection selection = selectSensors(train.temperatures, train.displacement, way.settings);
      way.picks.single += std::log(judged(train, tests, selection.sets[0].sensors) / best[0]) / spindles;
      way.picks.pair += std::log(judged(train, tests, selection.sets[1].sensors) / best[1]) / spindles;
    }
  }
  for (const Way& way : ways)
    std::cout << way.name << ", " << spindles << " spindles: single " << std::exp(way.picks.single)
              << ", pair " << std::exp(way.picks.pair) << '\n';
  EXPECT_LE(std::exp(ways[0].picks.single), 1.25);
  EXPECT_LE(std::exp(ways[0].picks.pair), 1.6);
}

/// Housings of another physics: 10, at full length 100.
TEST(SensorSelection, PicksWellOnMotorSpindles) {
  const int spindles = mm_test::longTests() ? 100 : 10;
  Picks picks;
  for (int k = 0; k < spindles; ++k) {
    const auto seed = 60000 + static_cast<std::uint64_t>(k);
    const MotorSpindle spindle(seed);
    const SpindleRun train = spindle.run(patentDuty(), 100, false, seed);
    const std::vector<SpindleRun> tests{spindle.run(randomDuty(2 * seed), 100, true, 1),
                                        spindle.run(randomDuty(2 * seed + 1), 100, true, 2)};
    double best[2] = {1e9, 1e9};
    for (int i = 0; i < MotorSpindle::kSensors; ++i) {
      best[0] = std::min(best[0], judged(train, tests, {i}));
      for (int j = i + 1; j < MotorSpindle::kSensors; ++j)
        best[1] = std::min(best[1], judged(train, tests, {i, j}));
    }
    SelectionSettings settings;
    settings.largestSize = 2;
    const SensorSelection selection = selectSensors(train.temperatures, train.displacement, settings);
    picks.single += std::log(judged(train, tests, selection.sets[0].sensors) / best[0]) / spindles;
    picks.pair += std::log(judged(train, tests, selection.sets[1].sensors) / best[1]) / spindles;
  }
  std::cout << spindles << " motor spindles: single " << std::exp(picks.single) << ", pair "
            << std::exp(picks.pair) << '\n';
  EXPECT_LE(std::exp(picks.single), 1.35);
  EXPECT_LE(std::exp(picks.pair), 1.6);
}

TEST(BlockedFolds, AreContiguousAndKeepTheGap) {
  const std::vector<Fold> folds = blockedFolds(10, 3, 1);
  ASSERT_EQ(folds.size(), 3u);
  EXPECT_EQ(folds[1].test, (std::vector<int>{3, 4, 5}));
  EXPECT_EQ(folds[1].train, (std::vector<int>{0, 1, 7, 8, 9}));
  EXPECT_THROW(blockedFolds(10, 1), InputError);
  EXPECT_THROW(blockedFolds(3, 4), InputError);
  EXPECT_THROW(blockedFolds(4, 2, 4), InputError);
}

}  // namespace
}  // namespace mm
