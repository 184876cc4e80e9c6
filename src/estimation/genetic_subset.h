#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "estimation/genetic.h"

namespace mm {

/// Settings of `subset`. None is in print; the defaults find the best of 10^5 subsets as a rule.
struct SubsetSettings {
  std::size_t population = 60;   // subsets, at least 2
  std::size_t generations = 80;  // 0: only the random population is scored
  std::uint64_t seed = 1;
  double mutation = 0.15;  // probability that an item of a child is exchanged for another

  /// Throws InputError naming the setting, its value and the bound.
  void validate() const;
};

struct SubsetResult {
  std::vector<std::size_t> items;  // ascending
  double score = 0.0;
  std::vector<double> curve;    // best score of each generation
  std::size_t evaluations = 0;  // subsets scored; each at most once
  std::size_t generations = 0;
  bool cancelled = false;  // the best so far
};

/// The score of `chosen` items (ascending); larger is better. One that is not finite ranks last.
using SubsetScore = std::function<double(const std::vector<std::size_t>& chosen)>;

/// The genetic algorithm of SENSORS: the `choose` of `items` whose score is largest, as (2) asks for the
/// temperatures that tell most of the deformation. A child takes what both parents have, then items of
/// either. Scores are remembered. Throws InputError for bad settings or when `choose` is not within 1 to
/// `items`; NumericalError when no subset has a finite score.
SubsetResult bestSubset(std::size_t items, std::size_t choose, const SubsetScore& score,
                        const SubsetSettings& settings = {}, const GeneticControl& control = {});

}  // namespace mm
