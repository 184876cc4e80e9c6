#include "estimation/genetic_niching.h"

#include <algorithm>
#include <cmath>

#include "estimation/genetic_run.h"

namespace mm {
namespace {

constexpr const char* kNiching = "niching";

/// Number of ranked chromosomes whose fitness 1 / (1 + cost) is above the mean; at least the best.
std::size_t aboveMean(const GeneticRun& run) {
  double sum = 0.0;
  for (std::size_t i = 0; i < run.population(); ++i) sum += 1.0 / (1.0 + run.rankedCost(i));
  const double mean = sum / static_cast<double>(run.population());
  std::size_t kept = 1;
  while (kept < run.population() && 1.0 / (1.0 + run.rankedCost(kept)) > mean) ++kept;
  return kept;
}

/// Mean square difference, each gene in parts of its range.
double separation(const double* a, const double* b, const GeneticRanges& ranges) {
  double sum = 0.0;
  for (std::size_t i = 0; i < ranges.dimension(); ++i) {
    const double difference = (a[i] - b[i]) / (ranges.high[i] - ranges.low[i]);
    sum += difference * difference;
  }
  return sum / static_cast<double>(ranges.dimension());
}

}  // namespace

void NichingSettings::validate() const {
  checkSettings(kNiching, *this);
  checkSetting(kNiching, "crossover", crossover, 0.0, 1.0);
  checkSetting(kNiching, "mutation", mutation, 0.0, 1.0);
  checkSetting(kNiching, "precision", precision, 1e-15, 0.1);
  checkSetting(kNiching, "threshold", threshold, 0.0, 1.0);
  checkSetting(kNiching, "reach", reach, 1e-15, 1.0);
}

GeneticResult runNiching(GeneticFitness& fitness, const GeneticRanges& ranges,
                         const NichingSettings& settings, const GeneticControl& control) {
  settings.validate();
  GeneticRun run(kNiching, fitness, ranges, settings, control);
  const std::size_t n = run.dimension(), population = run.population();
  const double nearest = settings.threshold * settings.threshold;
  std::vector<double> pool(population * n);
  const auto pooled = [&](std::size_t i) { return pool.data() + i * n; };

  run.fillFirst();
  while (run.closeGeneration()) {
    const std::size_t above = aboveMean(run);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < above; ++i) {
      const double* candidate = run.ranked(i);
      bool close = false;
      for (std::size_t k = 0; settings.eliminate && !close && k < kept; ++k)
        close = separation(candidate, pooled(k), ranges) < nearest;
      if (!close) std::copy_n(candidate, n, pooled(kept++));
    }
    GeneticRandom refill = run.random(population);  // a stream of its own
    const std::size_t parents = kept;
    for (std::size_t below = population - above; below > 0; --below)
      std::copy_n(pooled(refill.below(parents)), n, pooled(kept++));
    while (kept < population) run.fillRandom(pooled(kept++), refill);

    std::copy_n(pooled(0), n, run.chromosome(0));
    for (std::size_t i = 1; i < population; ++i) {
      GeneticRandom random = run.random(i);
      double* child = run.chromosome(i);
      std::copy_n(pooled(i), n, child);
      if (random.unit() < settings.crossover) {
        const double* mate = pooled(random.below(population));
        for (std::size_t j = 0; j < n; ++j) child[j] += random.unit() * (mate[j] - child[j]);
      }
      for (std::size_t j = 0; j < n; ++j) {
        const double range = ranges.high[j] - ranges.low[j];
        if (random.unit() < settings.mutation)
          child[j] += 0.5 * range * std::pow(settings.reach, random.unit()) * random.symmetric();
        const double step = settings.precision * range;
        child[j] = ranges.low[j] + step * std::round((child[j] - ranges.low[j]) / step);
        child[j] = std::clamp(child[j], ranges.low[j], ranges.high[j]);
      }
    }
  }
  return run.result();
}

}  // namespace mm
