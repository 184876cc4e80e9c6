// What every cause of the catalogue would do after refit of everything, on a nine-ball plate of 675 contacts:
// by the evidence of a linear-Gaussian model, all of them at once with every shape, period and time constant,
// against one warm-started fit by Ceres for one shape of each.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "diagnosis/evidence.h"
#include "diagnosis/question_list.h"
#include "estimation/noise_rows.h"
#include "estimation/refine.h"
#include "estimation/row_products.h"
#include "model/observed_domain.h"
#include "simulation/simulate.h"

namespace {

struct Base {
  mm::Simulation simulation = [] {
    const mm::Machine machine = mm::Machine::load("three_axis");
    return mm::simulate(machine, mm::Plan::load("config/plans/nine_ball_plate.yaml", machine),
                        {{"backlash:x=3um"}, 5, "", nullptr});
  }();
  mm::Model model{simulation.session.machine, mm::observedDomain(simulation.session),
                  std::vector<mm::EffectPtr>{}};
  mm::CalibrationResult fitted = [this] {
    mm::CalibrateOptions options;
    options.method = mm::Method::kLeastSquares;
    return mm::calibrate(simulation.session, model, options);
  }();
};

const Base& base() {
  static const Base kBase;
  return kBase;
}

struct Outcome {
  double seconds = 1e300;
  int causes = 0;
  std::string best;
};
Outcome byEvidence, byRefits;

template <class Run>
void measure(benchmark::State& state, Outcome& outcome, Run run) {
  base();
  for (auto _ : state) {
    const std::clock_t began = std::clock();  // of the processor, all threads
    run();
    const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
    state.SetIterationTime(seconds);
    outcome.seconds = std::min(outcome.seconds, seconds);
  }
}

void evidence(benchmark::State& state) {
  measure(state, byEvidence, [] {
    const mm::ResidualSpace space(base().fitted);
    const mm::LinearisedRows rows = mm::noiseRows(space.linearisation(), space.used(), base().fitted.sigma,
                                                  space.target(), space.basis());
    const mm::Groups groups = mm::QuestionList::causes(space).all();
    mm::NoiseModel noise;
    noise.variance = Eigen::VectorXd::Ones(rows.rows.rows());
    const mm::Evidence all(rows.rows, groups, noise, {}, {});
    const auto gains = all.gains(all.given({}));
    byEvidence.causes = static_cast<int>(gains.size());
    byEvidence.best = groups.groups[static_cast<std::size_t>(gains[0].group)].key;
  });
}

void refitsByCeres(benchmark::State& state) {
  const mm::ResidualSpace space(base().fitted);
  const mm::Groups groups = mm::QuestionList::causes(space).all();
  measure(state, byRefits, [&] {
    const mm::CalibrationResult& fitted = base().fitted;
    double least = 1e300;
    byRefits.causes = 0;
    for (const mm::Group& group : groups.groups) {
      const mm::EffectPtr effect = group.shapes[0].effect;
      std::vector<mm::EffectPtr> effects = base().model.effects();
      effects.push_back(effect);
      const mm::Model model(base().model.machine(), base().model.domain(), effects);
      const mm::Problem problem(base().simulation.session, model);
      const int before = base().model.parameterCount(), more = effect->parameterCount();
      Eigen::VectorXd x(fitted.x.size() + more);
      x.head(before) = fitted.x.head(before);
      for (int k = 0; k < more; ++k) x[before + k] = effect->parameters()[static_cast<std::size_t>(k)].start;
      x.tail(fitted.x.size() - before) = fitted.x.tail(fitted.x.size() - before);
      std::vector<char> fixed = fitted.identifiability.fixed;
      fixed.insert(fixed.begin() + before, static_cast<std::size_t>(more), 0);
      const mm::RefineResult r = mm::refine(problem, x, fixed, fitted.sigma, fitted.weight, {});
      const double rss =
          problem.residuals(r.x).cwiseQuotient(fitted.sigma).cwiseAbs2().cwiseProduct(fitted.weight).sum();
      ++byRefits.causes;
      if (rss < least) least = rss, byRefits.best = group.key;
    }
  });
}

/// Columns of a session whose balls have form errors: 160 nuisances with themselves, half of a diagnosis
/// there.
mm::RowMatrix nuisances() { return mm::RowMatrix::Random(675, 160); }
double ownSeconds = 1e300, eigenSeconds = 1e300;

template <class Run>
void products(benchmark::State& state, double& seconds, Run run) {
  const mm::RowMatrix columns = nuisances();
  for (auto _ : state) {
    const auto began = std::chrono::steady_clock::now();
    benchmark::DoNotOptimize(run(columns));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
    state.SetIterationTime(took.count());
    seconds = std::min(seconds, took.count());
  }
}

void rowProducts(benchmark::State& state) {
  products(state, ownSeconds, [](const mm::RowMatrix& m) { return mm::rowProducts(m); });
}

void eigenProducts(benchmark::State& state) {
  products(state, eigenSeconds, [](const mm::RowMatrix& m) {
    mm::RowMatrix out = mm::RowMatrix::Zero(m.cols(), m.cols());
    out.selfadjointView<Eigen::Lower>().rankUpdate(m.transpose());
    return out;
  });
}

BENCHMARK(rowProducts)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(eigenProducts)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(evidence)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(refitsByCeres)->Iterations(2)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  std::printf("evidence %.3f s, %d causes, best %s; refits by Ceres %.3f s, %d causes, best %s: %.0f times\n",
              byEvidence.seconds, byEvidence.causes, byEvidence.best.c_str(), byRefits.seconds,
              byRefits.causes, byRefits.best.c_str(), byRefits.seconds / byEvidence.seconds);
  std::printf("row products %.2f ms, Eigen's %.2f ms: %.2f of its time\n", 1e3 * ownSeconds,
              1e3 * eigenSeconds, ownSeconds / eigenSeconds);
}
