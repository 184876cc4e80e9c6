#include "fleet/sisters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/distributions.h"
#include "base/median.h"
#include "fleet/recurrence.h"
#include "fleet/robust_numbers.h"

namespace mm {
namespace {

TEST(RobustNumbers, tailsAreThoseOfTheTables) {
  EXPECT_NEAR(twoSidedT(2.228, 10), 0.05, 1e-4);
  EXPECT_NEAR(twoSidedT(1.959964, 1e9), 0.05, 1e-6);
  EXPECT_NEAR(chiSquaredTail(18.307, 10), 0.05, 1e-5);
  EXPECT_GT(twoSidedT(30.0, 1e9), 0.0);
  EXPECT_DOUBLE_EQ(median({3.0, 1.0, 2.0, 10.0}), 2.5);
}

TEST(Sisters, quietMachinesAreNotAccused) {
  std::mt19937_64 random(13);
  std::normal_distribution<double> normal;
  for (const int machines : {6, 20, 50}) {
    int accused = 0;
    constexpr int kFleets = 400;
    for (int f = 0; f < kFleets; ++f) {
      std::vector<Sister> sisters;
      for (int m = 0; m < machines; ++m)
        sisters.push_back({"m", 3.0 + 0.5 * normal(random) + 0.1 * normal(random), 0.1});
      for (const double p : sistersOf(sisters).p) accused += p < 1e-3;
    }
    const double expected = 1e-3 * machines * kFleets;
    EXPECT_LE(accused, expected + 4.0 * std::sqrt(expected) + 1.0) << machines;
  }
}

TEST(Sisters, quietMachinesOfASmallLaboratoryAreHardlyEverAccused) {
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal;
  for (const int machines : {4, 5, 7, 9, 10, 12}) {
    int accused = 0, asked = 0;
    for (int f = 0; f < 20000 / machines; ++f) {
      std::vector<Sister> sisters;
      for (int m = 0; m < machines; ++m)
        sisters.push_back({"m", 3.0 + 0.5 * normal(random) + 0.02 * normal(random), 0.02});
      for (const double p : sistersOf(sisters).p) {
        accused += p < 1e-4;
        ++asked;
      }
    }
    EXPECT_LE(accused, 8) << machines << " machines";  // of 20000 at 1e-4: 2, with the chance of counting
    EXPECT_GE(asked, 19900);
  }
}

TEST(Sisters, theOddOneOfTenIsFoundAmongTwentyQuantities) {
  std::mt19937_64 random(22);
  std::normal_distribution<double> normal;
  const double alpha = 0.01 / (10 * 20);
  int found = 0;
  constexpr int kFleets = 100;
  for (int f = 0; f < kFleets; ++f) {
    std::vector<Sister> sisters;
    for (int m = 0; m < 10; ++m) sisters.push_back({"m", 3.0 + 0.5 * normal(random), 0.05});
    sisters[4].value = 3.0 + 0.5 * 20.0;
    found += sistersOf(sisters).p[4] < alpha;
  }
  EXPECT_GE(found, 75);
}

TEST(RobustNumbers, theSpreadOfPairsIsTheStandardDeviation) {
  std::mt19937_64 random(23);
  std::normal_distribution<double> normal;
  for (const std::size_t count : {4u, 5u, 9u, 10u, 11u, 40u}) {
    double sum = 0.0;
    constexpr int kTrials = 4000;
    for (int i = 0; i < kTrials; ++i) {
      std::vector<double> values(count);
      for (double& v : values) v = 7.0 + 2.0 * normal(random);
      sum += pairSpread(values);
    }
    EXPECT_NEAR(sum / kTrials, 2.0, 0.12) << count;
  }
  EXPECT_TRUE(std::isnan(pairSpread({1.0})));
}

TEST(Sisters, theOddOneIsFoundAlsoAmongManyOddOnes) {
  std::mt19937_64 random(14);
  std::normal_distribution<double> normal;
  std::vector<Sister> sisters;
  for (int m = 0; m < 30; ++m) sisters.push_back({"m" + std::to_string(m), 2.0 + 0.2 * normal(random), 0.05});
  for (int m = 0; m < 9; ++m) sisters[static_cast<std::size_t>(m)].value += 5.0;
  const Sisterhood all = sistersOf(sisters);
  for (int m = 0; m < 30; ++m)
    EXPECT_EQ(all.p[static_cast<std::size_t>(m)] < 1e-3, m < 9)
        << m << " " << all.p[static_cast<std::size_t>(m)];
}

TEST(Sisters, threeMachinesSayNothing) {
  for (const double p : sistersOf({{"a", 1, 0.1}, {"b", 1, 0.1}, {"c", 99, 0.1}}).p) EXPECT_EQ(p, 1.0);
}

TEST(Recurrence, isFoundWhereAnEffectReturns) {
  std::vector<bool> found(36, true);
  for (std::size_t i = 12; i < 24; ++i) found[i] = false;
  const Recurrence r = recurrenceOf(found);
  EXPECT_GT(r.logOdds, std::log(1e4));
  EXPECT_EQ(r.gone, 12u);
  EXPECT_EQ(r.back, 24u);
}

TEST(Recurrence, isNotFoundInChanceInARepairOrInWear) {
  std::vector<bool> repaired(36, true), appeared(36, false);
  for (std::size_t i = 18; i < 36; ++i) {
    repaired[i] = false;
    appeared[i] = true;
  }
  EXPECT_LE(recurrenceOf(repaired).logOdds, 0.0);
  EXPECT_LE(recurrenceOf(appeared).logOdds, 0.0);
  std::mt19937_64 random(15);
  int alarms = 0;
  for (int i = 0; i < 4000; ++i) {
    std::vector<bool> chance;
    for (int k = 0; k < 30; ++k) chance.push_back(random() % 2 == 0);
    alarms += recurrenceOf(chance).logOdds > std::log(20.0);
  }
  EXPECT_LE(alarms, 4);  // at most 1 in 20 by Markov; hardly one where three periods are likely by no chance
}

}  // namespace
}  // namespace mm
