#include "estimation/genetic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "estimation/genetic_niching.h"
#include "estimation/genetic_staged_mutation.h"

namespace mm {
namespace {

/// Squared distance from (1, 2, … n) / 10.
class Bowl : public GeneticFitness {
 public:
  explicit Bowl(std::size_t dimension) : dimension_(dimension) {}
  std::size_t dimension() const override { return dimension_; }
  void evaluate(const double* population, std::size_t count, double* costs) const override {
    for (std::size_t i = 0; i < count; ++i) {
      costs[i] = 0.0;
      for (std::size_t j = 0; j < dimension_; ++j) {
        const double d = population[i * dimension_ + j] - 0.1 * static_cast<double>(j + 1);
        costs[i] += d * d;
      }
    }
  }

 private:
  std::size_t dimension_;
};

/// The same cost for every chromosome.
class Flat : public GeneticFitness {
 public:
  explicit Flat(double cost) : cost_(cost) {}
  std::size_t dimension() const override { return 2; }
  void evaluate(const double*, std::size_t count, double* costs) const override {
    for (std::size_t i = 0; i < count; ++i) costs[i] = cost_;
  }

 private:
  double cost_;
};

GeneticRanges cube(std::size_t n) { return {std::vector<double>(n, -1.0), std::vector<double>(n, 1.0)}; }

StagedMutationSettings smallSettings(std::uint64_t seed = 1) {
  StagedMutationSettings settings;
  settings.population = 150;
  settings.generations = 60;
  settings.seed = seed;
  return settings;
}

template <typename Action>
std::string messageOf(Action action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool names(const std::string& message, const std::string& word) {
  return message.find(word) != std::string::npos;
}

TEST(Genetic, badSettingsAreRefusedByName) {
  using S = StagedMutationSettings;
  Bowl bowl(3);
  const auto refused = [&](const char* name, void (*spoil)(S&)) {
    S settings;
    spoil(settings);
    const std::string message = messageOf([&] { runStagedMutation(bowl, cube(3), settings); });
    EXPECT_TRUE(names(message, name)) << name << ": " << message;
  };
  refused("population = 1", [](S& s) { s.population = 1; });
  refused("father_share = 0", [](S& s) { s.fatherShare = 0.0; });
  refused("father_share = nan", [](S& s) { s.fatherShare = std::nan(""); });
  refused("survivor_share = 2", [](S& s) { s.survivorShare = 2.0; });
  refused("gene_share = -1", [](S& s) { s.geneShare = -1.0; });
  refused("reach = 0", [](S& s) { s.reach = 0.0; });
  refused("stages is empty", [](S& s) { s.stages.clear(); });
  refused("stages[1].last_generation = 5", [](S& s) { s.stages = {{10, 1.0}, {5, 0.5}}; });
  refused("stages[0].fraction = -0.5", [](S& s) { s.stages = {{10, -0.5}}; });

  const auto refusedNiching = [&](const char* name, void (*spoil)(NichingSettings&)) {
    NichingSettings settings;
    spoil(settings);
    const std::string message = messageOf([&] { runNiching(bowl, cube(3), settings); });
    EXPECT_TRUE(names(message, name)) << name << ": " << message;
  };
  refusedNiching("crossover = 1.5", [](NichingSettings& s) { s.crossover = 1.5; });
  refusedNiching("mutation = -0.1", [](NichingSettings& s) { s.mutation = -0.1; });
  refusedNiching("precision = 0", [](NichingSettings& s) { s.precision = 0.0; });
  refusedNiching("threshold = 2", [](NichingSettings& s) { s.threshold = 2.0; });
}

TEST(Genetic, badRangesAreRefused) {
  Bowl bowl(3);
  GeneticRanges ranges = cube(3);
  ranges.high[1] = ranges.low[1];
  EXPECT_TRUE(names(messageOf([&] { runStagedMutation(bowl, ranges); }), "gene 1"));
  ranges.high[1] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(names(messageOf([&] { runStagedMutation(bowl, ranges); }), "gene 1"));
  EXPECT_TRUE(names(messageOf([&] { runStagedMutation(bowl, cube(2)); }), "3 genes"));
}

TEST(Genetic, zeroGenerationsGiveTheBestOfTheRandomPopulation) {
  Bowl bowl(3);
  StagedMutationSettings settings = smallSettings();
  settings.generations = 0;
  const GeneticResult result = runStagedMutation(bowl, cube(3), settings);
  EXPECT_EQ(result.generations, 0u);
  EXPECT_EQ(result.evaluations, 150u);
  ASSERT_EQ(result.curve.size(), 1u);
  EXPECT_EQ(result.curve[0], result.cost);
  double cost = 0.0;
  bowl.evaluate(result.best.data(), 1, &cost);
  EXPECT_EQ(cost, result.cost);
  EXPECT_FALSE(result.cancelled);
}

TEST(Genetic, findsTheMinimumWithACurveThatNeverRises) {
  Bowl bowl(5);
  NichingSettings niching;
  niching.generations = 200;
  // The elimination keeps the neighbours of the fittest away, so that niching is content with a part in a
  // hundred.
  const std::pair<GeneticResult, double> cases[] = {
      {runStagedMutation(bowl, cube(5), smallSettings()), 0.001}, {runNiching(bowl, cube(5), niching), 0.1}};
  for (const auto& [result, tolerance] : cases) {
    for (std::size_t j = 0; j < 5; ++j)
      EXPECT_NEAR(result.best[j], 0.1 * static_cast<double>(j + 1), tolerance);
    ASSERT_EQ(result.curve.size(), result.generations + 1);
    for (std::size_t g = 1; g < result.curve.size(); ++g) EXPECT_LE(result.curve[g], result.curve[g - 1]);
  }
}

TEST(Genetic, sameSeedSameBitsWithAnyNumberOfThreads) {
  Bowl bowl(4);
  NichingSettings niching;
  niching.generations = 30;
  std::vector<GeneticResult> staged, niched;
  for (const unsigned threads : {1u, 1u, 2u, 3u}) {
    StagedMutationSettings settings = smallSettings(9);
    settings.threads = niching.threads = threads;
    staged.push_back(runStagedMutation(bowl, cube(4), settings));
    niched.push_back(runNiching(bowl, cube(4), niching));
  }
  for (const auto& results : {staged, niched})
    for (const GeneticResult& other : results) {
      EXPECT_EQ(results[0].best, other.best);
      EXPECT_EQ(results[0].curve, other.curve);
      EXPECT_EQ(results[0].cost, other.cost);
    }
  EXPECT_NE(staged[0].best, runStagedMutation(bowl, cube(4), smallSettings(10)).best);
}

TEST(Genetic, cancelKeepsTheBestSoFar) {
  Bowl bowl(4);
  std::size_t seen = 0;
  double last = 0.0;
  GeneticControl control;
  control.progress = [&](const GeneticProgress& progress) {
    EXPECT_EQ(progress.generation, seen++);
    EXPECT_EQ(progress.generations, 60u);
    last = progress.cost;
  };
  control.cancelled = [&] { return seen == 6; };
  const GeneticResult result = runStagedMutation(bowl, cube(4), smallSettings(), control);
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.generations, 5u);
  EXPECT_EQ(result.evaluations, 6u * 150u);
  EXPECT_EQ(result.cost, last);
}

TEST(Genetic, populationWithoutAFiniteCostIsAnError) {
  Flat flat(std::nan(""));
  EXPECT_THROW(runStagedMutation(flat, cube(2), smallSettings()), NumericalError);
}

TEST(Genetic, exceptionOfTheFitnessPassesThroughThreads) {
  class Broken : public Flat {
   public:
    Broken() : Flat(0.0) {}
    void evaluate(const double*, std::size_t, double*) const override { throw std::logic_error("broken"); }
  } broken;
  StagedMutationSettings settings = smallSettings();
  settings.threads = 2;
  EXPECT_THROW(runStagedMutation(broken, cube(2), settings), std::logic_error);
}

}  // namespace
}  // namespace mm
