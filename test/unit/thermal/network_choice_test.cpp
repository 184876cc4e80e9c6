#include "thermal/network_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numeric>
#include <vector>

#include "base/error.h"
#include "heated_mill.h"
#include "long_tests.h"
#include "random_numbers.h"
#include "thermal/sensor_selection.h"

namespace mm {
namespace {

using namespace test_support;
using Eigen::MatrixXd;

double rms(const MatrixXd& errors) { return errors.norm() / std::sqrt(static_cast<double>(errors.size())); }

/// Two temperatures that rise and fall, and two displacements: `slope` um/K of the first, `bend` um/K^2 of
/// it.
struct Series {
  MatrixXd x, y;
  Series(int n, double slope, double bend, std::uint64_t seed) : x(n, 2), y(n, 2) {
    RandomNumbers random(seed);
    for (int i = 0; i < n; ++i) {
      const double rise = 5.0 + 4.0 * std::sin(0.31 * i) + random.normal(0.3);
      x.row(i) << 20.0 + rise, 21.0 + 2.0 * std::cos(0.23 * i) + random.normal(0.1);
      y(i, 0) = slope * rise + bend * rise * rise + random.normal(0.2);
      y(i, 1) = 0.5 * slope * rise + random.normal(0.2);
    }
  }
};

TEST(NetworkChoice, AutoTakesWhatPredictsHeldOutBlocksBest) {
  const Series line(60, 2.0, 0.0, 1), bend(90, 2.0, 0.5, 2), noise(60, 0.0, 0.0, 3);
  const NetworkChoice straight = chooseNetwork({}, line.x, line.y), bent = chooseNetwork({}, bend.x, bend.y),
                      none = chooseNetwork({}, noise.x, noise.y);
  ASSERT_EQ(straight.trials.size(), 4u);
  EXPECT_EQ(straight.kind, NetworkKind::kRidge);
  ASSERT_TRUE(bent.kind);
  EXPECT_NE(bent.kind, NetworkKind::kRidge);
  EXPECT_LT(bent.chosen().heldOutRms, 0.6 * bent.find("ridge")->heldOutRms);
  EXPECT_EQ(none.kind, std::nullopt);
  EXPECT_NE(none.reason.find("beats no network"), std::string::npos) << none.reason;
  for (const NetworkChoice* choice : {&straight, &bent, &none})
    for (const NetworkTrial& trial : choice->trials)
      EXPECT_LE(kClearlyLessError * choice->chosen().heldOutRms, trial.heldOutRms) << trial.name;
  EXPECT_NEAR(rms(bent.chosen().predicted - bend.y), bent.chosen().heldOutRms, 1e-12);
}

TEST(NetworkChoice, OneAskedForByNameWorksUnlessALineIsBetter) {
  const Series line(60, 2.0, 0.0, 4), bend(90, 2.0, 0.5, 5), noise(60, 0.0, 0.0, 6);
  EXPECT_EQ(chooseNetwork(NetworkKind::kDfnn, line.x, line.y).kind, NetworkKind::kDfnn);  // as good as a line
  EXPECT_EQ(chooseNetwork(NetworkKind::kDfnn, bend.x, bend.y).kind, NetworkKind::kDfnn);
  EXPECT_EQ(chooseNetwork(NetworkKind::kRidge, bend.x, bend.y).kind, NetworkKind::kRidge);
  const NetworkChoice instead = chooseNetwork(NetworkKind::kRbf, line.x, line.y);
  EXPECT_EQ(instead.kind, NetworkKind::kRidge);
  EXPECT_EQ(instead.chosen().name, "ridge");
  EXPECT_NE(instead.reason.find("instead of rbf, which is significantly worse"), std::string::npos)
      << instead.reason;
  for (const NetworkKind kind : {NetworkKind::kDfnn, NetworkKind::kRbf, NetworkKind::kRidge})
    EXPECT_EQ(chooseNetwork(kind, noise.x, noise.y).kind, std::nullopt) << nameOf(kind);
}

TEST(NetworkChoice, ChanceIsNoReasonButFailureInOneBlockIs) {
  RandomNumbers random(7);
  MatrixXd one(100, 3), other(100, 3);
  for (Eigen::Index i = 0; i < one.size(); ++i) {
    one.data()[i] = random.normal(1.0);
    other.data()[i] = random.normal(1.0);
  }
  EXPECT_FALSE(significantlyWorse(one, other));
  EXPECT_FALSE(significantlyWorse(other, one));
  EXPECT_FALSE(significantlyWorse(1.01 * one, one));  // certain, and of no account
  EXPECT_TRUE(significantlyWorse(1.1 * one, one));    // in every block
  MatrixXd failing = one;
  failing.middleRows(40, 10) *= 10.0;
  EXPECT_TRUE(significantlyWorse(failing, other));
  EXPECT_FALSE(significantlyWorse(other, failing));
  EXPECT_THROW(significantlyWorse(one, other.topRows(99)), InputError);
}

TEST(NetworkChoice, KnowsItsNames) {
  EXPECT_EQ(networkWish("auto"), std::nullopt);
  EXPECT_EQ(networkWish(""), std::nullopt);
  EXPECT_EQ(networkWish("rbf"), NetworkKind::kRbf);
  EXPECT_THROW(networkWish("perceptron"), InputError);
}

TEST(NetworkChoice, RefusesBadSeriesInOneLine) {
  Series good(40, 2.0, 0.0, 8);
  const auto refusal = [](const MatrixXd& x, const MatrixXd& y) -> std::string {
    try {
      chooseNetwork({}, x, y);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(refusal(good.x.topRows(3), good.y.topRows(3)).find("3 samples"), std::string::npos);
  EXPECT_NE(refusal(good.x, good.y.topRows(39)).find("the same length"), std::string::npos);
  MatrixXd gap = good.x;
  gap(4, 1) = std::nan("");
  EXPECT_NE(refusal(gap, good.y).find("not a finite number"), std::string::npos);
  MatrixXd still = good.x;
  still.col(1).setConstant(21.0);
  EXPECT_EQ(chooseNetwork({}, still, good.y).kind, NetworkKind::kRidge);  // and does no harm
  EXPECT_THROW(chooseNetwork({}, good.x, good.y, {}, [] { return false; }), Cancelled);
}

/// Heated mills, of a physics that no network knows: learned from three warm-ups, judged on another day at
/// another load.
TEST(NetworkChoice, OnAnotherDayItLeavesNoMoreThanALine) {
  const int machines = mm_test::longTests() ? 40 : mm_test::thoroughTests() ? 3 : 2;
  std::vector<ThermalLaw> laws = {ThermalLaw::kLinear, ThermalLaw::kBending};
  // every day Dfnn.OnMachinesIsMuchBetterThanRidgeWhereTheyBend has the third
  if (mm_test::thoroughTests()) laws.push_back(ThermalLaw::kSaturating);
  std::vector<double> minutes(11);
  for (int k = 0; k < 11; ++k) minutes[static_cast<std::size_t>(k)] = 20.0 * k;
  std::vector<NetworkWish> wishes = {{}, NetworkKind::kRbf};
  if (mm_test::longTests()) wishes.emplace_back(NetworkKind::kDfnn);
  for (const ThermalLaw law : laws) {
    double left[3] = {0.0, 0.0, 0.0}, line = 0.0, none = 0.0;  // mean logarithm
    int lines[3] = {0, 0, 0};
    for (int k = 0; k < machines; ++k) {
      const auto seed = static_cast<std::uint64_t>(k);
      const HeatedMill machine(9300 + seed, law);
      MatrixXd t(33, HeatedMill::kSensors), y(33, HeatedMill::kPositions);
      const double loads[3] = {1.0, 0.5, 1.3}, starts[3] = {20.5, 20.2, 20.8};
      for (int day = 0; day < 3; ++day) {
        const MillRun run = machine.run(minutes, starts[day], loads[day], 0.05, 0.2,
                                        10 * seed + static_cast<std::uint64_t>(day));
        t.middleRows(11 * day, 11) = run.temperatures;
        y.middleRows(11 * day, 11) = run.deviation;
      }
      const MillRun test = machine.run(minutes, 21.0, 0.6 + 0.3 * (k % 3), 0.05, 0.0, 1000 + seed);
      const Eigen::VectorXd grade = greyRelationalGrade(t, y);
      std::vector<int> order(HeatedMill::kSensors);
      std::iota(order.begin(), order.end(), 0);
      std::sort(order.begin(), order.end(), [&](int a, int b) { return grade(a) > grade(b); });
      MatrixXd x(33, 4), testX(11, 4);
      for (int i = 0; i < 4; ++i) {
        x.col(i) = t.col(order[static_cast<std::size_t>(i)]);
        testX.col(i) = test.temperatures.col(order[static_cast<std::size_t>(i)]);
      }
      const auto leftBy = [&](NetworkKind kind) {
        const auto network = makeNetwork(kind);
        network->fit(x, y);
        return std::log(rms(network->evaluateAll(testX) - test.deviation)) / machines;
      };
      line += leftBy(NetworkKind::kRidge);
      none += std::log(rms(test.deviation)) / machines;
      for (std::size_t w = 0; w < wishes.size(); ++w) {
        const NetworkChoice choice = chooseNetwork(wishes[w], x, y);
        ASSERT_TRUE(choice.kind) << choice.reason;
        left[w] += leftBy(*choice.kind);
        lines[w] += *choice.kind == NetworkKind::kRidge;
      }
    }
    for (std::size_t w = 0; w < wishes.size(); ++w) {
      const char* const names[] = {"auto", "rbf", "dfnn"};
      std::cout << names[w] << " leaves " << std::exp(left[w] - line) << " of ridge-linear, "
                << std::exp(left[w] - none) << " of none; ridge-linear works on " << lines[w] << " of "
                << machines << '\n';
      EXPECT_LE(std::exp(left[w] - line), 1.1) << names[w];
    }
    EXPECT_LT(std::exp(left[0] - none), 0.5);
  }
}

}  // namespace
}  // namespace mm
