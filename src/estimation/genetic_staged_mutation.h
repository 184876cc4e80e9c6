#pragma once
#include <cstddef>
#include <vector>

#include "estimation/genetic.h"

namespace mm {

/// A stage of the mutation: up to and including generation `lastGeneration`, genes change by at most
/// `fraction` of half their range.
struct MutationStage {
  std::size_t lastGeneration = 0;
  double fraction = 1.0;
};

/// Settings of `staged_mutation`.
struct StagedMutationSettings : GeneticSettings {
  /// The best share of a generation are the fathers of the next.
  double fatherShare = 0.2;
  /// In rising order of generations and until the last one; the last stage also holds after its end. The
  /// first three are the published ones (3760, 1880 and 188 um of 3760 um); boundaries of the others were
  /// found by trial.
  std::vector<MutationStage> stages = {{15, 1.0}, {30, 0.5}, {50, 0.05}, {75, 0.005}, {100, 0.0005}};
  // The next three are not in print. Defaults found by trial on 70 x 233 contacts with 18 free constants,
  // ranges of 40, 100 and 400 um over the volume: 1.00, 1.00 and 1.01 times the optimal RMS, where one gene
  // at a time and no survivors (as MMT, and 0, 1, 1) reach 1.8, 3.4 and 18 times.
  /// Share of the population that lives on unchanged, best first, evaluated again; the best one always does.
  double survivorShare = 0.1;
  /// Probability that an axis of a child is mutated; one axis at least always is.
  double geneShare = 0.2;
  /// Each child's range is the stage's times reach^v, v uniform in 0 … 1: 1 is a plain uniform mutation,
  /// smaller values mix fine steps in, so that a stage goes on to converge where its full range is too
  /// coarse.
  double reach = 0.1;

  /// Throws InputError naming the setting, its value and the bound.
  void validate() const;
};

/// The genetic algorithm of MMT: random population; the best 20 % are the fathers of the next generation,
/// whose children are mutated fathers; the range of the mutation shrinks in stages. Mutated are the axes that
/// the fitness states (GeneticFitness::principalAxes), or as in MMT the genes where it states none.
/// @throw InputError, NumericalError as runNiching.
GeneticResult runStagedMutation(GeneticFitness& fitness, const GeneticRanges& ranges,
                                const StagedMutationSettings& settings = {},
                                const GeneticControl& control = {});

}  // namespace mm
