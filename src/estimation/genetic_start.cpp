#include "estimation/genetic_start.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/units.h"
#include "estimation/linear_fitness.h"
#include "estimation/residual_fitness.h"

namespace mm {
namespace {

bool allLinear(const Problem& problem) {
  return std::all_of(problem.model().effects().begin(), problem.model().effects().end(),
                     [](const EffectPtr& e) { return e->separable(); });
}

/// The unknowns that the algorithm searches: where all is linear the centres follow by themselves.
std::vector<int> genesOf(const Problem& problem, const std::vector<char>& fixed, bool linear) {
  std::vector<int> genes;
  for (int u = 0; u < problem.unknownCount(); ++u) {
    const UnknownKind kind = problem.unknowns()[u].kind;
    if (!fixed[u] &&
        (kind == UnknownKind::kEffect || kind == UnknownKind::kSetup ||
         (!linear && kind != UnknownKind::kRadius && !ResidualFitness::solvedInClosedForm(problem, u))))
      genes.push_back(u);
  }
  return genes;
}

/// How far from its start an unknown is searched, SI.
double halfRange(const Problem& problem, const Unknown& unknown) {
  constexpr double kOfScale = 1e-3;  // of a parameter whose start is zero: else its range would be empty
  // a mount is searched about where the chain says it is: 1 mm, 0.6 deg and 0.1 of the beam's direction,
  // and the features about where the contacts say they are
  const double near = std::min(unknown.bound, 10.0 * unknown.scale);
  if (unknown.kind != UnknownKind::kEffect) return near;
  const Effect& effect = *problem.model().effects()[unknown.owner];
  double half = effect.nature().unitVectors.empty() ? unknown.bound : near;
  if (effect.nature().ofUnknownSize)
    half = 10.0 * std::max(std::abs(unknown.start), kOfScale * unknown.scale);
  if (unknown.priorStd > 0.0) half = std::min(half, 5.0 * unknown.priorStd);
  return half;
}

GeneticRanges rangesOf(const Problem& problem, const Eigen::VectorXd& x, const std::vector<int>& genes) {
  GeneticRanges ranges;
  for (const int u : genes) {
    const Unknown& unknown = problem.unknowns()[u];
    const double half = halfRange(problem, unknown);
    ranges.low.push_back(std::max(x[u] - half, unknown.minimum));
    ranges.high.push_back(std::min(x[u] + half, unknown.maximum));
  }
  return ranges;
}

/// The algorithm that was asked for. @param threads of its evaluations.
GeneticResult search(GeneticFitness& fitness, const GeneticRanges& ranges, const CalibrateOptions& options,
                     int threads) {
  GeneticControl control;
  control.cancelled = options.cancelled;
  control.progress = [&](const GeneticProgress& p) {
    if (options.progress)
      options.progress("genetic",
                       static_cast<double>(p.generation) / std::max<std::size_t>(1, p.generations));
  };
  const auto run = [&](auto settings, auto algorithm) {
    settings.seed = options.seed;
    settings.threads = threads;
    return algorithm(fitness, ranges, settings, control);
  };
  return options.method == Method::kNiching ? run(options.niching, runNiching)
                                            : run(options.stagedMutation, runStagedMutation);
}

}  // namespace

GeneticSummary geneticStart(const Problem& problem, Eigen::VectorXd& x, const std::vector<char>& fixed,
                            const Eigen::VectorXd& sigma, const Eigen::VectorXd& weight,
                            const CalibrateOptions& options) {
  const bool linear = allLinear(problem);
  double unit = 0.0;  // the mean sigma: costs are then squares of metres (or radians)
  for (int i = 0; i < sigma.size(); ++i) unit += sigma[i] / static_cast<double>(sigma.size());
  const Eigen::VectorXd inverseSigma = weight.cwiseSqrt().cwiseQuotient(sigma);
  const std::vector<int> genes = genesOf(problem, fixed, linear);
  GeneticSummary summary;
  summary.method = nameOf(options.method);
  summary.seed = options.seed;
  if (genes.empty()) {
    summary.stop = "nothing to search";
    return summary;
  }
  // LASER's fitness 1 / (1 + G) has a unit: G is in mm^2
  const double length = !linear && options.method == Method::kNiching ? kMillimetre : 1.0;
  std::unique_ptr<GeneticFitness> fitness;
  ResidualFitness* nonlinear = nullptr;
  if (linear) {
    fitness = linearFitness(problem, x, fixed, genes, inverseSigma, unit);
  } else {
    auto residuals =
        std::make_unique<ResidualFitness>(problem, x, genes, inverseSigma, unit, length, options.cancelled);
    nonlinear = residuals.get();
    fitness = std::move(residuals);
  }
  GeneticResult found;
  try {
    // formulas are parsed by a thread at a time
    found = search(*fitness, rangesOf(problem, x, genes), options, linear ? options.threads : 1);
  } catch (const NumericalError&) {
    if (!options.cancelled || !options.cancelled()) throw;
    summary.stop = "cancelled";  // before the first generation: the start is the best
    return summary;
  }
  for (std::size_t g = 0; g < genes.size(); ++g) x[genes[g]] = found.best[g];
  if (nonlinear != nullptr) nonlinear->solve(x);
  summary.rms = std::sqrt(found.cost) * length;
  for (const double cost : found.curve) summary.curve.push_back(std::sqrt(cost) * length);
  summary.generations = found.generations;
  summary.evaluations = found.evaluations;
  summary.seconds = found.seconds;
  summary.stop = found.cancelled ? "cancelled" : "generations";
  return summary;
}

}  // namespace mm
