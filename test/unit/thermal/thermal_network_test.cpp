#include "thermal/thermal_network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "heated_mill.h"
#include "long_tests.h"
#include "random_numbers.h"
#include "thermal/sensor_selection.h"

namespace mm {
namespace {

using namespace test_support;
using Eigen::MatrixXd;

double rms(const MatrixXd& a, const MatrixXd& b) {
  return std::sqrt((a - b).squaredNorm() / static_cast<double>(a.size()));
}

/// The function of Wu and Er's first example.
struct Hermite {
  MatrixXd x, y;
  Hermite(int n, std::uint64_t seed) : x(n, 1), y(n, 1) {
    RandomNumbers random(seed);
    for (int i = 0; i < n; ++i) {
      const double v = x(i, 0) = random.uniform(-4.0, 4.0);
      y(i, 0) = 1.1 * (1.0 - v + 2.0 * v * v) * std::exp(-v * v / 2.0);
    }
  }
};

/// Three temperatures that drift, and two outputs linear in them.
struct Linear {
  MatrixXd x, y;
  Linear(int n, std::uint64_t seed, double bend = 0.0) : x(n, 3), y(n, 2) {
    RandomNumbers random(seed);
    for (int i = 0; i < n; ++i) {
      const double warm = random.uniform(0.0, 10.0);
      x.row(i) << 20.0 + warm + random.normal(0.5), 21.0 + 0.5 * warm + random.normal(0.3),
          random.uniform(19.0, 21.0);
      const double rise = x(i, 0) - 20.0;
      y(i, 0) = 3.0 * rise + bend * rise * rise - 2.0 * x(i, 2);
      y(i, 1) = -1.0 * x(i, 1) + random.normal(0.01);
    }
  }
};

std::unique_ptr<ThermalNetwork> fitted(NetworkKind kind, const MatrixXd& x, const MatrixXd& y,
                                       const NetworkSettings& settings = {}) {
  std::unique_ptr<ThermalNetwork> network = makeNetwork(kind, settings);
  network->fit(x, y);
  return network;
}

constexpr NetworkKind kKinds[] = {NetworkKind::kDfnn, NetworkKind::kRbf, NetworkKind::kRidge};

TEST(Dfnn, LearnsTheHermiteFunction) {
  for (std::uint64_t seed = 1; seed <= (mm_test::thoroughTests() ? 3 : 1); ++seed) {
    const Hermite train(200, seed), test(200, 100 + seed);
    const auto network = fitted(NetworkKind::kDfnn, train.x, train.y);
    EXPECT_GE(network->rules(), 5);
    EXPECT_LE(network->rules(), 8);
    EXPECT_LE(rms(network->evaluateAll(test.x), test.y), 0.006);
  }
}

TEST(Dfnn, AsPublishedGrowsAboutSixRules) {
  NetworkSettings settings;
  settings.dfnn.published = true;
  settings.dfnn.standardise = false;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Hermite train(200, seed), test(200, 100 + seed);
    const auto network = fitted(NetworkKind::kDfnn, train.x, train.y, settings);
    EXPECT_GE(network->rules(), 5);
    EXPECT_LE(network->rules(), 7);
    EXPECT_LE(rms(network->evaluateAll(test.x), test.y), 0.08);
  }
}

TEST(Dfnn, IsAsGoodAsRidgeWhereTheTruthIsLinear) {
  const Linear train(60, 1), test(200, 2);
  const auto dfnn = fitted(NetworkKind::kDfnn, train.x, train.y),
             ridge = fitted(NetworkKind::kRidge, train.x, train.y);
  EXPECT_LE(rms(dfnn->evaluateAll(test.x), test.y), 1.05 * rms(ridge->evaluateAll(test.x), test.y));
}

TEST(Dfnn, IsBetterThanRidgeWhereTheTruthBends) {
  const Linear train(60, 3, 0.3), test(200, 4, 0.3);
  const auto dfnn = fitted(NetworkKind::kDfnn, train.x, train.y),
             ridge = fitted(NetworkKind::kRidge, train.x, train.y);
  EXPECT_GT(dfnn->rules(), 1);
  EXPECT_LE(rms(dfnn->evaluateAll(test.x), test.y), 0.6 * rms(ridge->evaluateAll(test.x), test.y));
}

TEST(Dfnn, StaysFiniteFarFromAllRules) {
  const Hermite train(100, 5);
  const auto network = fitted(NetworkKind::kDfnn, train.x, train.y);
  for (double x : {-1e6, -100.0, 100.0, 1e6}) {
    double y = 0.0;
    network->evaluate(&x, &y);
    EXPECT_TRUE(std::isfinite(y)) << x;
  }
}

TEST(Dfnn, RefusesMoreRulesThanSamplesAndBadThresholds) {
  NetworkSettings settings;
  settings.dfnn.largestRules = 20;
  const Linear few(10, 1);
  EXPECT_THROW(fitted(NetworkKind::kDfnn, few.x, few.y, settings), InputError);
  settings.dfnn.largestRules = 65;
  EXPECT_THROW(makeNetwork(NetworkKind::kDfnn, settings), InputError);
  settings = {};
  settings.dfnn.errorDecay = 1.5;
  EXPECT_THROW(makeNetwork(NetworkKind::kDfnn, settings), InputError);
}

TEST(Rbf, MeetsEverySample) {
  const Linear train(30, 6);
  const auto network = fitted(NetworkKind::kRbf, train.x, train.y);
  EXPECT_EQ(network->rules(), 30);
  EXPECT_LE(rms(network->evaluateAll(train.x), train.y), 1e-3);
}

TEST(Ridge, RecoversALine) {
  const Linear train(100, 7), test(50, 8);
  const auto network = fitted(NetworkKind::kRidge, train.x, train.y);
  EXPECT_LE(rms(network->evaluateAll(test.x), test.y), 0.02);
}

TEST(Network, ComesBackFromItsNumbersToTheBit) {
  const Linear train(40, 9, 0.2), test(20, 10, 0.2), more(20, 11, 0.2);
  for (NetworkKind kind : kKinds)
    for (bool published : {false, true}) {
      NetworkSettings settings;
      settings.dfnn.published = published;
      const auto network = fitted(kind, train.x, train.y, settings);
      const auto copy = networkFromNumbers(network->toNumbers());
      EXPECT_EQ(copy->kind(), kind);
      EXPECT_EQ(copy->rules(), network->rules());
      EXPECT_EQ(copy->evaluateAll(test.x), network->evaluateAll(test.x));
      copy->update(more.x, more.y);
      network->update(more.x, more.y);
      EXPECT_EQ(copy->evaluateAll(test.x), network->evaluateAll(test.x));
    }
}

TEST(Network, RefusesDamagedNumbers) {
  const Linear train(20, 12);
  std::vector<double> numbers = fitted(NetworkKind::kDfnn, train.x, train.y)->toNumbers();
  EXPECT_THROW(networkFromNumbers({}), InputError);
  EXPECT_THROW(networkFromNumbers({numbers.begin(), numbers.end() - 1}), InputError);
  numbers.push_back(0.0);
  EXPECT_THROW(networkFromNumbers(numbers), InputError);
  numbers.pop_back();
  numbers[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(networkFromNumbers(numbers), InputError);
}

TEST(Network, ANewSetIsLearnedAndTheOldOneKept) {
  const Linear all(120, 13, 0.2);
  Eigen::Index cold = 0;
  MatrixXd x[2] = {MatrixXd(120, 3), MatrixXd(120, 3)}, y[2] = {MatrixXd(120, 2), MatrixXd(120, 2)};
  Eigen::Index count[2] = {0, 0};
  for (Eigen::Index i = 0; i < 120; ++i) {  // cold samples first, warm ones as the new set
    const int warm = all.x(i, 0) > 25.0;
    x[warm].row(count[warm]) = all.x.row(i);
    y[warm].row(count[warm]++) = all.y.row(i);
  }
  cold = count[0];
  for (NetworkKind kind : kKinds) {
    const auto network = fitted(kind, x[0].topRows(cold), y[0].topRows(cold));
    const double before = rms(network->evaluateAll(x[1].topRows(count[1])), y[1].topRows(count[1]));
    network->update(x[1].topRows(count[1]), y[1].topRows(count[1]));
    const double after = rms(network->evaluateAll(x[1].topRows(count[1])), y[1].topRows(count[1]));
    const double old = rms(network->evaluateAll(x[0].topRows(cold)), y[0].topRows(cold));
    EXPECT_LT(after, 0.5 * before) << nameOf(kind);
    EXPECT_LT(old, 0.5 * before) << nameOf(kind);
  }
}

TEST(Network, RefusesBadSeries) {
  for (NetworkKind kind : kKinds) {
    Linear train(20, 14);
    EXPECT_THROW(fitted(kind, train.x.topRows(1), train.y.topRows(1)), InputError);
    EXPECT_THROW(fitted(kind, train.x, train.y.topRows(19)), InputError);
    const auto network = fitted(kind, train.x, train.y);
    EXPECT_THROW(network->update(train.x.leftCols(2), train.y), InputError);
    EXPECT_THROW(makeNetwork(kind)->update(train.x, train.y), InputError);
    train.x(2, 1) = std::nan("");
    EXPECT_THROW(network->update(train.x, train.y), InputError);
  }
  EXPECT_THROW(networkKind("perceptron"), InputError);
}

TEST(Network, AConstantSensorDoesNoHarm) {
  Linear train(40, 15);
  train.x.col(2).setConstant(20.0);
  for (NetworkKind kind : kKinds)
    EXPECT_TRUE(fitted(kind, train.x, train.y)->evaluateAll(train.x).allFinite());
}

TEST(GreyRelation, GradesAsDefined) {
  // Reference 0, 1/2, 1; input 1 equals it, input 2 deviates by 1/2 in the middle, input 3 is input 1
  // falling.
  MatrixXd inputs(3, 4), output(3, 1);
  inputs << 20, 0, 9, 5, 21, 0, 8, 5, 22, 1, 7, 5;
  output << 0, 5, 10;
  const Eigen::VectorXd grade = greyRelationalGrade(inputs, output);
  EXPECT_NEAR(grade(0), 1.0, 1e-12);
  EXPECT_NEAR(grade(1), (1.0 + 0.25 / 0.75 + 1.0) / 3.0, 1e-12);
  EXPECT_NEAR(grade(2), 1.0, 1e-12);
  EXPECT_EQ(grade(3), 0.0);
  EXPECT_THROW(greyRelationalGrade(inputs, output.topRows(2)), InputError);
}

/// Median of RMS test errors over machines: three warm-ups at different loads, tested on a fourth.
struct Medians {
  double dfnn = 0.0, ridge = 0.0;
};

Medians onMachines(ThermalLaw law, int machines) {
  std::vector<double> minutes(11), dfnn, ridge;
  for (int k = 0; k < 11; ++k) minutes[static_cast<std::size_t>(k)] = 20.0 * k;
  for (int k = 0; k < machines; ++k) {
    const auto seed = static_cast<std::uint64_t>(k);
    const HeatedMill machine(100 + seed, law);
    MatrixXd t(33, HeatedMill::kSensors), y(33, HeatedMill::kPositions);
    const double loads[3] = {1.0, 0.5, 1.3}, starts[3] = {20.5, 20.2, 20.8};
    for (int day = 0; day < 3; ++day) {
      const MillRun run = machine.run(minutes, starts[day], loads[day], 0.05, 0.2,
                                      10 * seed + static_cast<std::uint64_t>(day));
      t.middleRows(11 * day, 11) = run.temperatures;
      y.middleRows(11 * day, 11) = run.deviation;
    }
    const MillRun test = machine.run({0, 60, 120}, 21.0, 0.6 + 0.3 * (k % 3), 0.05, 0.0, 1000 + seed);
    const Eigen::VectorXd grade = greyRelationalGrade(t, y);
    std::vector<int> order(HeatedMill::kSensors);
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) { return grade(a) > grade(b); });
    MatrixXd x(33, 4), testX(3, 4);
    for (int i = 0; i < 4; ++i) {
      x.col(i) = t.col(order[static_cast<std::size_t>(i)]);
      testX.col(i) = test.temperatures.col(order[static_cast<std::size_t>(i)]);
    }
    dfnn.push_back(rms(fitted(NetworkKind::kDfnn, x, y)->evaluateAll(testX), test.deviation));
    ridge.push_back(rms(fitted(NetworkKind::kRidge, x, y)->evaluateAll(testX), test.deviation));
  }
  const auto median = [](std::vector<double>& v) {
    std::sort(v.begin(), v.end());
    return v[v.size() / 2];
  };
  return {median(dfnn), median(ridge)};
}

int machines() { return mm_test::longTests() ? 40 : 8; }

TEST(Dfnn, OnMachinesIsNotWorseThanRidgeWhereLinear) {
  const Medians m = onMachines(ThermalLaw::kLinear, machines());
  EXPECT_LE(m.dfnn, 1.05 * m.ridge);
}

TEST(Dfnn, OnMachinesIsMuchBetterThanRidgeWhereTheyBend) {
  const Medians saturating = onMachines(ThermalLaw::kSaturating, machines()),
                bending = onMachines(ThermalLaw::kBending, machines());
  EXPECT_LE(saturating.dfnn, 0.6 * saturating.ridge);
  EXPECT_LE(bending.dfnn, 0.6 * bending.ridge);
}

}  // namespace
}  // namespace mm
