#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace mm {

/// The range of each gene, in the genes' own units (SI where they are physical).
struct GeneticRanges {
  std::vector<double> low, high;

  std::size_t dimension() const { return low.size(); }  ///< number of genes
  /// Throws InputError, naming the gene, when a range is empty, not finite, or not of `dimension` genes.
  void validate(std::size_t dimension) const;
};

/// What a genetic algorithm minimises: the cost of many chromosomes at a time.
class GeneticFitness {
 public:
  virtual ~GeneticFitness() = default;

  /// Number of genes of a chromosome.
  virtual std::size_t dimension() const = 0;

  /// Writes the cost of `count` chromosomes, rows of `population` (row-major, count x dimension()), to
  /// `costs`. Smaller is better; a cost that is not finite ranks last. Called from several threads at once,
  /// with disjoint blocks, when the settings ask for more than one; the cost of a chromosome must not depend
  /// on its neighbours in the block.
  virtual void evaluate(const double* population, std::size_t count, double* costs) const = 0;

  /// Called from the driver's thread, while no evaluation runs: before the first generation with the middle
  /// of the ranges, then after each generation with its best. Unknowns that are not genes (ball centres) are
  /// recomputed here. Returns true when the costs of chromosomes have changed.
  virtual bool newGeneration(const double* best) {
    (void)best;
    return false;
  }

  /// Directions in which the cost varies independently (rows of dimension() values, in the genes' units),
  /// each so long that it changes the residuals as much as the others do; the strongest is half its range
  /// long. Asked for once, after the first newGeneration(). Empty: not known, and the genes themselves are
  /// the directions.
  virtual std::vector<double> principalAxes(const GeneticRanges& ranges) const {
    (void)ranges;
    return {};
  }
};

/// Settings that all the genetic algorithms share. Each algorithm's own follow in a struct derived from this
/// one.
struct GeneticSettings {
  std::size_t population = 500;   // chromosomes, at least 2
  std::size_t generations = 100;  // 0: only the random population is evaluated
  std::uint64_t seed = 1;
  unsigned threads = 1;  // 0: all cores. Results do not depend on it
};

/// One generation, as seen by the progress callback.
struct GeneticProgress {
  std::size_t generation = 0;   // 0 is the random population
  std::size_t generations = 0;  // asked for
  double cost = 0.0;            // of the best chromosome
};

/// Callbacks of a run, both optional, called from the caller's thread once a generation.
struct GeneticControl {
  std::function<void(const GeneticProgress&)> progress;
  std::function<bool()> cancelled;  // true ends the run; the best chromosome so far is kept
};

/// What a run found.
struct GeneticResult {
  std::vector<double> best;   // chromosome, in the ranges' units
  double cost = 0.0;          // of `best`, with the unknowns of newGeneration at their last values
  std::vector<double> curve;  // best cost of each generation, from the random population on
  std::size_t evaluations = 0;
  std::size_t generations = 0;  // completed
  bool cancelled = false;       // before the last generation
  double seconds = 0.0;         // wall clock; the only figure that differs between two runs with one seed
};

}  // namespace mm
