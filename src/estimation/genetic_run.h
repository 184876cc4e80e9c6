#pragma once
#include <chrono>
#include <cstddef>
#include <vector>

#include "base/parallel.h"
#include "estimation/genetic.h"
#include "estimation/genetic_random.h"

namespace mm {

/// Throws InputError unless low <= value <= high: "staged_mutation: father_share = 2 is above 1; …".
void checkSetting(const char* algorithm, const char* name, double value, double low, double high);
/// Checks the settings that all algorithms share.
void checkSettings(const char* algorithm, const GeneticSettings& settings);

/// The bookkeeping of one run, the same for every algorithm: evaluation in threads, ranking, curve,
/// callbacks, stop. Use: fill chromosome(i) of a population, then closeGeneration(), until it returns false;
/// then result().
class GeneticRun {
 public:
  GeneticRun(const char* algorithm, GeneticFitness& fitness, const GeneticRanges& ranges,
             const GeneticSettings& settings, const GeneticControl& control);

  std::size_t dimension() const { return dimension_; }             ///< number of genes
  std::size_t population() const { return settings_.population; }  ///< chromosomes
  /// The chromosome to be written, of the generation being made.
  double* chromosome(std::size_t i) { return next_.data() + i * dimension_; }
  /// The i-th best chromosome of the last generation, and its cost.
  const double* ranked(std::size_t i) const { return current_.data() + order_[i] * dimension_; }
  double rankedCost(std::size_t i) const { return costs_[order_[i]]; }
  /// Number of the generation being made; 0 is the random population.
  std::size_t generation() const { return generation_; }
  /// The random stream of chromosome i of the generation being made.
  GeneticRandom random(std::size_t i) const { return {settings_.seed, generation_, i}; }
  /// Writes a random chromosome within the ranges.
  void fillRandom(double* chromosome, GeneticRandom& random) const;
  /// Writes the first population, which is random.
  void fillFirst();

  /// Evaluates and ranks what was written; false when the run is over.
  bool closeGeneration();
  GeneticResult result();

 private:
  void evaluate();
  void rank();

  const char* algorithm_;
  GeneticFitness& fitness_;
  const GeneticRanges& ranges_;
  const GeneticSettings& settings_;
  const GeneticControl& control_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  const std::size_t dimension_;
  std::size_t generation_ = 0;
  std::vector<double> current_, next_, costs_;
  std::vector<std::size_t> order_;
  Threads threads_;
  GeneticResult result_;
  bool changed_ = false;
};

}  // namespace mm
