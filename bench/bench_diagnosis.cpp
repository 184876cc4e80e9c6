// What every effect of the catalogue would do after refit of everything, on a nine-ball plate of 675
// contacts: by projection, all of them at once, against one warm-started fit by Ceres for each. The fits take
// one start only for each effect, where the projection looks at every period and time constant of its grid as
// well.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <ctime>

#include "diagnosis/candidates.h"
#include "diagnosis/subset_search.h"
#include "estimation/polish.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace {

struct Base {
  mm::Simulation simulation = [] {
    const mm::Machine machine = mm::Machine::load("three_axis");
    return mm::simulate(machine, mm::Plan::load("config/plans/nine_ball_plate.yaml", machine),
                        {{"backlash:x=3um"}, 5});
  }();
  mm::Model model{simulation.session.machine, mm::observedDomain(simulation.session),
                  std::vector<mm::EffectPtr>{}};
  mm::CalibrationResult fitted = [this] {
    mm::CalibrateOptions options;
    options.method = mm::Method::kLeastSquares;
    mm::CalibrationResult r = mm::calibrate(simulation.session, model, options);
    r.problem->linearise(r.x);
    return r;
  }();
};

const Base& base() {
  static const Base kBase;
  return kBase;
}

struct Outcome {
  double seconds = 1e300;
  int effects = 0;
  std::string best;
};
Outcome projected, refitted;

template <class Run>
void measure(benchmark::State& state, Outcome& outcome, Run run) {
  base();
  for (auto _ : state) {
    const std::clock_t began = std::clock();  // of the processor, both threads of the projection
    run();
    const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
    state.SetIterationTime(seconds);
    outcome.seconds = std::min(outcome.seconds, seconds);
  }
}

void projection(benchmark::State& state) {
  measure(state, projected, [] {
    const mm::ResidualSpace space(base().fitted);
    const mm::CandidateSet set = mm::makeCandidates(space);
    const mm::SubsetSearch search(space, set);
    const auto gains = search.bestGains(search.empty(), static_cast<int>(set.candidates.size()), false);
    projected.effects = static_cast<int>(gains.size());
    projected.best = set.candidates[static_cast<std::size_t>(gains[0].candidate)].spec.yaml();
  });
}

void refitsByCeres(benchmark::State& state) {
  const mm::ResidualSpace space(base().fitted);
  const mm::CandidateSet set = mm::makeCandidates(space);
  measure(state, refitted, [&] {
    const mm::CalibrationResult& fitted = base().fitted;
    double least = 1e300;
    refitted.effects = 0;
    for (const mm::Candidate& c : set.candidates) {
      if (!c.tried) continue;
      std::vector<mm::EffectPtr> effects = base().model.effects();
      effects.push_back(c.effect);
      const mm::Model model(base().model.machine(), base().model.domain(), effects);
      const mm::Problem problem(base().simulation.session, model);
      const int before = base().model.parameterCount(), more = c.effect->parameterCount();
      Eigen::VectorXd x(fitted.x.size() + more);
      x.head(before) = fitted.x.head(before);
      for (int k = 0; k < more; ++k)
        x[before + k] = c.effect->parameters()[static_cast<std::size_t>(k)].start;
      x.tail(fitted.x.size() - before) = fitted.x.tail(fitted.x.size() - before);
      std::vector<char> fixed = fitted.identifiability.fixed;
      fixed.insert(fixed.begin() + before, static_cast<std::size_t>(more), 0);
      const mm::PolishResult r = mm::polish(problem, x, fixed, fitted.sigma, fitted.weight, {});
      const double rss =
          problem.residuals(r.x).cwiseQuotient(fitted.sigma).cwiseAbs2().cwiseProduct(fitted.weight).sum();
      ++refitted.effects;
      if (rss < least) least = rss, refitted.best = c.spec.yaml();
    }
  });
}

BENCHMARK(projection)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(refitsByCeres)->Iterations(2)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  std::printf(
      "projection %.3f s, %d effects, best %s; refits by Ceres %.3f s, %d effects, best %s: %.0f times\n",
      projected.seconds, projected.effects, projected.best.c_str(), refitted.seconds, refitted.effects,
      refitted.best.c_str(), refitted.seconds / projected.seconds);
}
