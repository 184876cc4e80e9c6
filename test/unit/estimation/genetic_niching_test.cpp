#include "estimation/genetic_niching.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

/// A wide, shallow bowl of cost 0.3 and more about (0.5, … 0.5) and a narrow, deep one of cost 0 about (-0.6,
/// … -0.6).
class TwoBowls : public GeneticFitness {
 public:
  std::size_t dimension() const override { return 4; }
  void evaluate(const double* population, std::size_t count, double* costs) const override {
    for (std::size_t i = 0; i < count; ++i) {
      double wide = 0.0, narrow = 0.0;
      for (std::size_t j = 0; j < 4; ++j) {
        const double x = population[4 * i + j];
        wide += (x - 0.5) * (x - 0.5);
        narrow += (x + 0.6) * (x + 0.6);
      }
      costs[i] = std::min(0.3 + wide, 5.0 * narrow);
    }
  }
};

int timesFound(bool eliminate) {
  const GeneticRanges ranges{std::vector<double>(4, -1.0), std::vector<double>(4, 1.0)};
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    NichingSettings settings;
    settings.population = 60;
    settings.generations = 150;
    settings.seed = seed;
    settings.eliminate = eliminate;
    TwoBowls fitness;
    if (runNiching(fitness, ranges, settings).cost < 0.15) ++found;
  }
  return found;
}

TEST(Niching, findsTheDeepMinimumMoreOftenThanTheTraditionalAlgorithm) {
  const int niching = timesFound(true), traditional = timesFound(false);
  RecordProperty("niching", niching);
  RecordProperty("traditional", traditional);
  EXPECT_GE(niching, traditional + 10) << niching << " and " << traditional << " of 50";
  EXPECT_GE(niching, 35);
}

TEST(Niching, genesAreMultiplesOfThePrecision) {
  NichingSettings settings;
  settings.precision = 1.0 / 64;
  settings.generations = 20;
  TwoBowls fitness;
  const GeneticRanges ranges{std::vector<double>(4, -1.0), std::vector<double>(4, 1.0)};
  for (double gene : runNiching(fitness, ranges, settings).best) {
    const double steps = (gene + 1.0) * 32.0;
    EXPECT_EQ(steps, std::round(steps));
  }
}

}  // namespace
}  // namespace mm
