#include "estimation/genetic_staged_mutation.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "estimation/genetic_run.h"

namespace mm {
namespace {

constexpr const char* kStagedMutation = "staged_mutation";

/// A gene that leaves its range is reflected at the bound; what is still outside takes the bound itself.
double within(double value, double low, double high) {
  if (value < low) value = 2.0 * low - value;
  if (value > high) value = 2.0 * high - value;
  return std::clamp(value, low, high);
}

/// Directions of mutation, and the largest part of each that stays within half the ranges.
struct Axes {
  std::vector<double> rows, most;
  bool genes = false;  // row i changes gene i only
};

Axes axesOf(const GeneticFitness& fitness, const GeneticRanges& ranges) {
  const std::size_t n = ranges.dimension();
  Axes axes{fitness.principalAxes(ranges), {}};
  axes.genes = axes.rows.empty();
  if (axes.genes) {
    axes.rows.assign(n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) axes.rows[i * n + i] = 0.5 * (ranges.high[i] - ranges.low[i]);
  }
  for (std::size_t first = 0; first < axes.rows.size(); first += n) {
    double square = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      const double part = axes.rows[first + i] / (0.5 * (ranges.high[i] - ranges.low[i]));
      square += part * part;
    }
    axes.most.push_back(1.0 / std::sqrt(square));
  }
  return axes;
}

double fractionOf(const std::vector<MutationStage>& stages, std::size_t generation) {
  for (const MutationStage& stage : stages)
    if (generation <= stage.lastGeneration) return stage.fraction;
  return stages.back().fraction;
}

}  // namespace

void StagedMutationSettings::validate() const {
  checkSettings(kStagedMutation, *this);
  checkSetting(kStagedMutation, "father_share", fatherShare, 1e-6, 1.0);
  checkSetting(kStagedMutation, "survivor_share", survivorShare, 0.0, fatherShare);
  checkSetting(kStagedMutation, "gene_share", geneShare, 0.0, 1.0);
  checkSetting(kStagedMutation, "reach", reach, 1e-12, 1.0);
  if (stages.empty()) throw InputError("staged_mutation: stages is empty; give at least one stage");
  std::size_t last = 0;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const std::string name = "stages[" + std::to_string(i) + "]";
    checkSetting(kStagedMutation, (name + ".fraction").c_str(), stages[i].fraction, 0.0, 2.0);
    if (stages[i].lastGeneration <= last)
      throw InputError("staged_mutation: " + name +
                       ".last_generation = " + std::to_string(stages[i].lastGeneration) + " is not above " +
                       std::to_string(last) + "; list the stages in rising order");
    last = stages[i].lastGeneration;
  }
}

GeneticResult runStagedMutation(GeneticFitness& fitness, const GeneticRanges& ranges,
                                const StagedMutationSettings& settings, const GeneticControl& control) {
  settings.validate();
  GeneticRun run(kStagedMutation, fitness, ranges, settings, control);
  const std::size_t n = run.dimension();
  const Axes axes = axesOf(fitness, ranges);
  const std::size_t axisCount = axes.most.size();
  const auto shareOf = [&](double share) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(share * static_cast<double>(run.population())));
  };
  const std::size_t fathers = shareOf(settings.fatherShare);
  const std::size_t survivors = shareOf(settings.survivorShare);

  run.fillFirst();
  while (run.closeGeneration()) {
    const double fraction = fractionOf(settings.stages, run.generation());
    for (std::size_t i = 0; i < run.population(); ++i) {
      double* child = run.chromosome(i);
      std::copy_n(run.ranked(i < survivors ? i : (i - survivors) % fathers), n, child);
      if (i < survivors) continue;
      GeneticRandom random = run.random(i);
      const double step = fraction * std::pow(settings.reach, random.unit());
      const std::size_t certain = random.below(axisCount);
      for (std::size_t a = 0; a < axisCount; ++a) {
        if (a != certain && settings.geneShare < 1.0 && random.unit() >= settings.geneShare) continue;
        const double amount = std::min(step, axes.most[a]) * random.symmetric();
        const double* axis = axes.rows.data() + a * n;
        if (axes.genes)
          child[a] += amount * axis[a];
        else
          for (std::size_t j = 0; j < n; ++j) child[j] += amount * axis[j];
      }
      for (std::size_t j = 0; j < n; ++j) child[j] = within(child[j], ranges.low[j], ranges.high[j]);
    }
  }
  return run.result();
}

}  // namespace mm
