// staged_mutation against pagmo's sga at the size of MMT: 70 ball positions x 233 contacts, 18 free
// constants, the centres unknown; population 500, 100 generations, the same data and ranges.
#include <benchmark/benchmark.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <map>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <string>
#include <utility>
#include <vector>

#include "estimation/genetic_staged_mutation.h"
#include "genetic_mmt_problem.h"

namespace {

using mm_test::MmtContacts;
constexpr double kRange = 100e-6, kNoise = 0.5e-6;
constexpr std::size_t kN = MmtContacts::kContactsPerBall, kBalls = MmtContacts::kBalls;

const MmtContacts& data() {
  static const MmtContacts kData(17, 40e-6, kNoise);
  return kData;
}

/// The peer's data, as its user would lay them out: columns of doubles, ball by ball, so that the compiler
/// vectorises over contacts. The same rule for the centres: recomputed with the best of each generation, and
/// followed to first order.
struct Columns {
  std::array<std::array<std::vector<double>, 7>, 3> factor;
  std::array<std::vector<double>, 3> reading, normal;
  std::vector<Eigen::Vector3d> centre = data().nominalCentres;
  std::vector<Eigen::Matrix3d> inverse = std::vector<Eigen::Matrix3d>(kBalls);

  Columns() {
    for (const Eigen::Vector3d& q : data().readings)
      for (int axis = 0; axis < 3; ++axis) {
        const auto f = MmtContacts::factors(axis, q);
        for (std::size_t k = 0; k < 7; ++k) factor[static_cast<std::size_t>(axis)][k].push_back(f[k]);
        reading[static_cast<std::size_t>(axis)].push_back(q[axis]);
        normal[static_cast<std::size_t>(axis)].push_back(0.0);
      }
    recentre(std::vector<double>(18, 0.0).data());
  }

  /// Least-squares centres of the contacts corrected with `genes`.
  void recentre(const double* genes) {
    std::array<double, MmtContacts::kConstants> constants;
    mm_test::scatterGenes(genes, constants.data());
    std::array<std::vector<double>, 3> corrected = reading;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < 7; ++k)
        for (std::size_t i = 0; i < corrected[axis].size(); ++i)
          corrected[axis][i] += constants[7 * axis + k] * factor[axis][k][i];
    for (std::size_t b = 0; b < kBalls; ++b) {
      for (int iteration = 0; iteration < 2; ++iteration) {
        Eigen::Matrix3d h = Eigen::Matrix3d::Zero();
        Eigen::Vector3d g = Eigen::Vector3d::Zero();
        for (std::size_t i = b * kN; i < (b + 1) * kN; ++i) {
          const Eigen::Vector3d p =
              Eigen::Vector3d(corrected[0][i], corrected[1][i], corrected[2][i]) - centre[b];
          const Eigen::Vector3d n = p.normalized();
          h += n * n.transpose();
          g += (p.norm() - MmtContacts::kDistance) * n;
          for (std::size_t axis = 0; axis < 3; ++axis) normal[axis][i] = n[static_cast<Eigen::Index>(axis)];
        }
        inverse[b] = h.inverse();
        centre[b] += inverse[b] * g;
      }
    }
  }
};

/// Sum of the squares and of residual times normal over the contacts of one ball.
__attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default"))) void ballSums(
    const Columns& columns, std::size_t first, const double* constants, const double* centre, double* sums) {
  double moved[3][kN];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double* c = constants + 7 * axis;
    const double* q = columns.reading[axis].data() + first;
    const double *f0 = columns.factor[axis][0].data() + first, *f1 = columns.factor[axis][1].data() + first,
                 *f2 = columns.factor[axis][2].data() + first, *f3 = columns.factor[axis][3].data() + first,
                 *f4 = columns.factor[axis][4].data() + first, *f5 = columns.factor[axis][5].data() + first,
                 *f6 = columns.factor[axis][6].data() + first;
    for (std::size_t i = 0; i < kN; ++i)
      moved[axis][i] = q[i] - centre[axis] + c[0] * f0[i] + c[1] * f1[i] + c[2] * f2[i] + c[3] * f3[i] +
                       c[4] * f4[i] + c[5] * f5[i] + c[6] * f6[i];
  }
  const double *nx = columns.normal[0].data() + first, *ny = columns.normal[1].data() + first,
               *nz = columns.normal[2].data() + first;
  double square = 0.0, x = 0.0, y = 0.0, z = 0.0;
  for (std::size_t i = 0; i < kN; ++i) {
    const double r =
        __builtin_sqrt(moved[0][i] * moved[0][i] + moved[1][i] * moved[1][i] + moved[2][i] * moved[2][i]) -
        MmtContacts::kDistance;
    square += r * r;
    x += r * nx[i];
    y += r * ny[i];
    z += r * nz[i];
  }
  sums[0] = square;
  sums[1] = x;
  sums[2] = y;
  sums[3] = z;
}

double peerCost(const Columns& columns, const double* genes) {
  std::array<double, MmtContacts::kConstants> constants;
  mm_test::scatterGenes(genes, constants.data());
  double total = 0.0;
  for (std::size_t b = 0; b < kBalls; ++b) {
    double sums[4];
    ballSums(columns, b * kN, constants.data(), columns.centre[b].data(), sums);
    const Eigen::Vector3d g(sums[1], sums[2], sums[3]);
    total += sums[0] - g.dot(columns.inverse[b] * g);
  }
  return total / static_cast<double>(kBalls * kN);
}

/// RMS in micrometres of a chromosome with its own least-squares centres: one judge for both algorithms.
double judge(const std::vector<double>& genes) {
  Columns columns;
  for (int i = 0; i < 3; ++i) columns.recentre(genes.data());
  return 1e6 * std::sqrt(peerCost(columns, genes.data()));
}

mm::GeneticRanges rangesOfGenes() {
  mm::GeneticRanges ranges;
  mm_test::mmtFitness(data(), kRange, mm::CentreRule::kFollow, ranges);
  return ranges;
}

/// pagmo's problem, in units of half a range, cost in square micrometres.
struct Peer {
  Columns* columns = nullptr;
  std::vector<double> half;
  pagmo::vector_double fitness(const pagmo::vector_double& x) const {
    std::array<double, 18> genes;
    for (std::size_t i = 0; i < 18; ++i) genes[i] = x[i] * half[i];
    return {1e12 * peerCost(*columns, genes.data())};
  }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(18, -1.0), pagmo::vector_double(18, 1.0)};
  }
  pagmo::thread_safety get_thread_safety() const { return pagmo::thread_safety::none; }
};

struct Outcome {
  double seconds = 0.0, rms = 0.0;
  int runs = 0;
};
std::map<std::string, Outcome>& outcomes() {
  static std::map<std::string, Outcome> kOutcomes;
  return kOutcomes;
}

template <typename Run>
void measure(benchmark::State& state, const std::string& name, Run run) {
  unsigned seed = 0;
  for (auto _ : state) {
    const auto began = std::chrono::steady_clock::now();
    const std::vector<double> genes = run(++seed);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    state.SetIterationTime(seconds);
    state.PauseTiming();
    Outcome& outcome = outcomes()[name];
    outcome.seconds += seconds;
    outcome.rms += judge(genes);
    ++outcome.runs;
    state.ResumeTiming();
  }
  state.counters["rms_um"] = outcomes()[name].rms / outcomes()[name].runs;
}

void stagedMutation(benchmark::State& state) {
  const auto threads = static_cast<unsigned>(state.range(0));
  measure(state, "staged_mutation, threads " + std::to_string(threads), [&](unsigned seed) {
    mm::GeneticRanges ranges;
    mm::SphereFitness fitness = mm_test::mmtFitness(data(), kRange, mm::CentreRule::kFollow, ranges);
    mm::StagedMutationSettings settings;
    settings.seed = seed;
    settings.threads = threads;
    return mm::runStagedMutation(fitness, ranges, settings).best;
  });
}

std::vector<double> runPagmo(pagmo::sga algorithm, unsigned seed) {
  const mm::GeneticRanges ranges = rangesOfGenes();
  Columns columns;
  Peer peer{&columns, ranges.high};
  pagmo::population population(pagmo::problem(peer), 500, seed);
  std::vector<double> best(18);
  for (int generation = 0; generation < 100; ++generation) {
    population = algorithm.evolve(population);
    const pagmo::vector_double x = population.get_x()[population.best_idx()];
    for (std::size_t i = 0; i < 18; ++i) best[i] = x[i] * ranges.high[i];
    columns.recentre(best.data());
  }
  return best;
}

void pagmoDefault(benchmark::State& state) {
  measure(state, "pagmo sga, its defaults", [](unsigned seed) {
    return runPagmo(pagmo::sga(1, .90, 1., .02, 1., 2, "exponential", "polynomial", "tournament", seed),
                    seed);
  });
}

void pagmoTuned(benchmark::State& state) {
  measure(state, "pagmo sga, sbx and gaussian", [](unsigned seed) {
    return runPagmo(pagmo::sga(1, .90, 10., .1, .02, 5, "sbx", "gaussian", "tournament", seed), seed);
  });
}

BENCHMARK(stagedMutation)->Arg(2)->Arg(1)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pagmoDefault)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(pagmoTuned)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  const auto mean = [](const Outcome& outcome, double value) { return value / std::max(outcome.runs, 1); };
  for (const auto& [own, ours] : outcomes()) {
    if (own.rfind("staged", 0) != 0) continue;
    for (const auto& [other, theirs] : outcomes())
      if (other.rfind("pagmo", 0) == 0)
        std::printf("%s / %s: time %.3f s / %.3f s = %.3f, rms %.3f um / %.3f um\n", own.c_str(),
                    other.c_str(), mean(ours, ours.seconds), mean(theirs, theirs.seconds),
                    mean(ours, ours.seconds) / mean(theirs, theirs.seconds), mean(ours, ours.rms),
                    mean(theirs, theirs.rms));
  }
}
