#pragma once
#include "estimation/genetic.h"

namespace mm {

/// Settings of `niching`. Crossover, mutation and precision are LASER's; the paper does not state the others.
/// Their defaults were found by trial on LASER's Table 2, ranges of 1 mm, 0.6 deg and 0.1 about the nominal
/// mount (examples/laser_probe/convergence.py). With so narrow ranges there is one niche: the traditional
/// algorithm is there first, and the elimination pays where a wide bowl hides a deep one.
struct NichingSettings : GeneticSettings {
  NichingSettings() {
    population = 200;
    generations = 500;
  }
  double crossover = 0.5;  // probability that a chromosome is crossed with another
  double mutation = 0.05;  // probability that a gene is mutated
  /// Genes are multiples of this part of their range.
  double precision = 1e-6;
  /// Chromosomes closer than this are dropped: Euclidean distance, each gene in parts of its range, divided
  /// by the root of the number of genes (so that 1 is the diagonal of the ranges).
  double threshold = 0.1;
  /// False: the traditional genetic algorithm that LASER compares with, the same without the elimination of
  /// close ones.
  bool eliminate = true;
  /// A mutation changes a gene by at most half its range times reach^v, v uniform in 0 … 1; 1: a uniform
  /// mutation.
  double reach = 1e-6;

  /// Throws InputError naming the setting, its value and the bound.
  void validate() const;
};

/// The improved genetic algorithm of LASER: sort by fitness 1 / (1 + cost) (12); keep those above the mean
/// fitness; drop those that are close to any fitter one (LASER: to the fittest), for random ones, and take
/// copies of kept ones for those below the mean; cross and mutate. The best chromosome always lives on.
/// @throw InputError for invalid settings, or ranges that do not fit the fitness; NumericalError when no
/// chromosome has a finite cost. An exception of the fitness or of a callback passes through.
GeneticResult runNiching(GeneticFitness& fitness, const GeneticRanges& ranges,
                         const NichingSettings& settings = {}, const GeneticControl& control = {});

}  // namespace mm
