#include "fleet/prior.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "fleet_support.h"

namespace mm {
namespace {

TEST(PopulationPrior, coversTheNextMachine) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (const int machines : {6, 12, 50}) {
    int inside = 0;
    constexpr int kFleets = 1000;
    for (int f = 0; f < kFleets; ++f) {
      const auto one = [&] { return 4.0 + 0.8 * normal(random); };
      std::vector<Sister> sisters;
      for (int m = 0; m < machines; ++m) sisters.push_back({"m", one() + 0.3 * normal(random), 0.3});
      const PopulationPrior prior = predictiveOf(sisters);
      inside += std::abs(one() - prior.mean) < 2.0 * prior.std;
    }
    EXPECT_GE(inside, 930) << machines;  // 95.4 % of a normal, with the chance of 1000 trials
  }
}

TEST(PopulationPrior, isTheSpreadOfTheMachinesWhereTheyAreKnownWell) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  std::vector<Sister> sisters;
  for (int m = 0; m < 200; ++m) sisters.push_back({"m", 4.0 + 0.8 * normal(random), 0.01});
  const PopulationPrior prior = predictiveOf(sisters);
  EXPECT_NEAR(prior.mean, 4.0, 0.2);
  EXPECT_NEAR(prior.std, 0.8, 0.12);
}

TEST(PopulationPrior, isNotNarrowWhereMachinesAreHardlyKnown) {
  std::vector<Sister> sisters;  // the same value by chance: their spread may still be some of 0.3
  for (int m = 0; m < 6; ++m) sisters.push_back({"m", 4.0, 0.3});
  EXPECT_GT(predictiveOf(sisters).std, 0.12);
}

TEST(PopulationPrior, takesADriftingMachineAsItIsNow) {
  MadeUpFleet made(9, 6, 24);
  for (int m = 0; m < 6; ++m)
    for (int k = 0; k < 24; ++k) made.at(m, k).result.parameters[0].value += 10.0 * k / 23.0;
  const Fleet fleet = fleetOf(made.records, {});
  for (const PopulationPrior& p : populationPriors(fleet, ""))
    if (p.effect == "{type: backlash, axis: a0}") {
      EXPECT_NEAR(p.mean, 12.0, 0.7);  // about 2 at the beginning
      EXPECT_LT(p.std, 1.5);
    }
}

TEST(PopulationPrior, leavesOutWhatAMachineDoesNotDetermine) {
  MadeUpFleet made(9, 7, 4);
  for (int k = 0; k < 4; ++k) {
    made.at(2, k).result.parameters[0].std = std::numeric_limits<double>::infinity();
    made.at(3, k).result.converged = false;
  }
  const std::vector<PopulationPrior> priors = populationPriors(fleetOf(made.records, {}), "m007");
  ASSERT_EQ(priors.size(), 8u);
  for (const PopulationPrior& p : priors) {
    EXPECT_NE(p.effect, "{type: backlash, axis: a0}");  // of four machines
    EXPECT_EQ(p.machines, 5u);
  }
}

TEST(Conflict, isTheTailOfChiSquared) {
  EXPECT_NEAR(conflictOf(18.307, 10), 0.05, 1e-4);
  EXPECT_EQ(conflictOf(3.0, 0), 1.0);
}

}  // namespace
}  // namespace mm
