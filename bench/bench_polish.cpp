// The polish against the same least-squares problem in plain Ceres: one automatically differentiated residual
// block a contact, at the size of MMT (70 ball positions x 233 contacts, 18 free constants, the centres
// unknown), the same start, the same tolerances. The peer with Ceres' own first trust region and with the
// wide one that the polish takes for a model that is linear in its constants.
#include <benchmark/benchmark.h>
#include <ceres/ceres.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <map>
#include <string>
#include <vector>

#include "estimation/identifiability.h"
#include "estimation/refine.h"
#include "mmt_session.h"

namespace {

using mm_test::MmtContacts;
constexpr double kNoise = 0.5e-6;  // m
constexpr int kFree = 18;
constexpr int kTightest = 200;  // iterations

const MmtContacts& data() {
  static const MmtContacts kData(17, 40e-6, kNoise);
  return kData;
}

const mm::Session& session() {
  static const mm::Session kSession = mm_test::mmtSession(data(), kNoise);
  return kSession;
}

/// What both start from: the problem with its gauge fixed.
struct Start {
  mm::Problem problem{session(), mm_test::mmtModel(session())};
  Eigen::VectorXd x = problem.start();
  Eigen::VectorXd sigma = problem.sigmas(kNoise, kNoise);
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(problem.rowCount());
  std::vector<char> fixed = mm::identify(problem, x, sigma.cwiseInverse(), true).fixed;
};

const Start& start() {
  static const Start kStart;
  return kStart;
}

/// One contact as its user would write it: MMT (13) with the factors of the reading computed once, then (16).
struct Contact {
  Eigen::Vector3d reading;
  std::array<std::array<double, 7>, 3> factors;

  template <typename T>
  bool operator()(const T* constants, const T* centre, T* residual) const {
    using std::sin;
    using std::sqrt;
    T square(0.0);
    const T* c = constants;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      T p = reading[static_cast<Eigen::Index>(axis)] - centre[axis] * kLength;
      for (std::size_t k = 0; k < 7; ++k) {
        if (MmtContacts::fixed(7 * axis + k)) continue;
        const T value = *c++ * kConstant;
        p += factors[axis][k] * (k < 5 ? value : sin(value));
      }
      square += p * p;
    }
    residual[0] = (sqrt(square) - MmtContacts::kDistance) / kNoise;
    return true;
  }

  static constexpr double kLength = 1e-4, kConstant = 1e-4;  // units of the unknowns: m; 1, 1/m or rad
};

ceres::LinearSolverType solverOf(int index) {
  return index == 0 ? ceres::DENSE_SCHUR : index == 1 ? ceres::SPARSE_SCHUR : ceres::SPARSE_NORMAL_CHOLESKY;
}

struct Outcome {
  double seconds = 1e300, rms = 0.0;  // best of the runs; um
  int iterations = 0;
};
std::map<std::string, Outcome>& outcomes() {
  static std::map<std::string, Outcome> kOutcomes;
  return kOutcomes;
}

template <typename Run>
void measure(benchmark::State& state, const std::string& name, Run run) {
  start();
  Outcome& outcome = outcomes()[name];
  for (auto _ : state) {
    const std::clock_t began = std::clock();  // of the processor: all run on one thread
    run(outcome);
    const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
    state.SetIterationTime(seconds);
    outcome.seconds = std::min(outcome.seconds, seconds);
  }
  state.counters["rms_um"] = outcome.rms;
  state.counters["iterations"] = outcome.iterations;
}

void polish(benchmark::State& state) {
  measure(state, "polish", [](Outcome& outcome) {
    const Start& s = start();
    const mm::RefineResult r = mm::refine(s.problem, s.x, s.fixed, s.sigma, s.weight, {});
    outcome.rms = 1e6 * std::sqrt(s.problem.residuals(r.x).squaredNorm() / s.problem.rowCount());
    outcome.iterations = r.iterations;
  });
}

void plainCeres(benchmark::State& state) {
  const ceres::LinearSolverType type = solverOf(static_cast<int>(state.range(0)));
  const bool wide = state.range(1) != 0;
  const std::string name = std::string("plain Ceres, ") + ceres::LinearSolverTypeToString(type);
  measure(state, name + (wide ? ", wide trust region" : ""), [&](Outcome& outcome) {
    const Start& s = start();
    std::vector<double> constants(kFree, 0.0);
    std::vector<std::array<double, 3>> centres(MmtContacts::kBalls);
    for (std::size_t b = 0; b < centres.size(); ++b)
      for (int k = 0; k < 3; ++k)
        centres[b][static_cast<std::size_t>(k)] =
            s.problem.featureInWorkpiece(static_cast<int>(b), 0, s.x)[k] / Contact::kLength;
    ceres::Problem problem;
    for (std::size_t i = 0; i < data().readings.size(); ++i) {
      auto* contact = new Contact{data().readings[i], {}};
      for (int axis = 0; axis < 3; ++axis)
        contact->factors[static_cast<std::size_t>(axis)] = MmtContacts::factors(axis, contact->reading);
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Contact, 1, kFree, 3>(contact), nullptr,
                               constants.data(), centres[data().ball[i]].data());
    }
    ceres::Solver::Options options;
    options.num_threads = 1;
    options.max_num_iterations = kTightest;
    options.function_tolerance = 1e-15;  // those of the polish
    options.parameter_tolerance = 1e-13;
    options.gradient_tolerance = 1e-16;
    options.logging_type = ceres::SILENT;
    if (wide) options.initial_trust_region_radius = 1e9;
    options.linear_solver_type = type;
    if (type != ceres::SPARSE_NORMAL_CHOLESKY) {
      options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
      for (auto& centre : centres) options.linear_solver_ordering->AddElementToGroup(centre.data(), 0);
      options.linear_solver_ordering->AddElementToGroup(constants.data(), 1);
    }
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    outcome.rms =
        1e6 * kNoise * std::sqrt(2.0 * summary.final_cost / static_cast<double>(data().readings.size()));
    outcome.iterations = static_cast<int>(summary.iterations.size()) - 1;
  });
}

BENCHMARK(polish)->Iterations(5)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK(plainCeres)
    ->ArgsProduct({{0, 1, 2}, {0, 1}})
    ->Iterations(5)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  const Outcome& own = outcomes()["polish"];
  for (const auto& [name, other] : outcomes())
    if (name != "polish")
      std::printf("polish / %s: time %.3f s / %.3f s = %.3f, rms %.6f um / %.6f um, %d / %d iterations\n",
                  name.c_str(), own.seconds, other.seconds, own.seconds / other.seconds, own.rms, other.rms,
                  own.iterations, other.iterations);
}
