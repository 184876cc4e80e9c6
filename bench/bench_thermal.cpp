// Evaluation of a network, and the information of subsets of sensors.
#include <benchmark/benchmark.h>

#include "spindle_simulation.h"
#include "thermal/mutual_information.h"
#include "thermal/sensor_selection.h"
#include "thermal/thermal_network.h"

namespace {

using namespace mm;
using namespace mm::test_support;

/// 9 rules, 4 temperatures, 11 positions: the network of DFNN.
void evaluateNineRules(benchmark::State& state) {
  RandomNumbers random(1);
  Eigen::MatrixXd x(200, 4), y(200, 11);
  for (int i = 0; i < 200; ++i) {
    for (int s = 0; s < 4; ++s) x(i, s) = random.uniform(20.0, 30.0);
    for (int p = 0; p < 11; ++p) y(i, p) = std::sin(x(i, 0)) * p + std::cos(x(i, 1) + x(i, 2) * x(i, 3));
  }
  NetworkSettings settings;
  settings.dfnn.published = true;
  settings.dfnn.pruning = 0.0;
  settings.dfnn.largestRules = 9;
  const auto network = makeNetwork(NetworkKind::kDfnn, settings);
  network->fit(x, y);
  if (network->rules() != 9) state.SkipWithError("the network has not nine rules");
  double in[4] = {22.0, 23.0, 24.0, 25.0}, out[11];
  for (auto _ : state) {
    in[0] += 1e-9;
    network->evaluate(in, out);
    benchmark::DoNotOptimize(out);
  }
}
BENCHMARK(evaluateNineRules);

/// One subset of the given size by KSG on 100 samples.
void ksgSubset(benchmark::State& state) {
  const SpindleRun run = RandomSpindle(1).run(patentDuty(), 100, 0.05, 0.2, 1);
  const SensorInformation information(run.temperatures, run.displacement, {});
  std::vector<int> subset;
  for (int s = 0; s < state.range(0); ++s) subset.push_back(7 * s);
  for (auto _ : state) benchmark::DoNotOptimize(information.joint(subset));
}
BENCHMARK(ksgSubset)->Arg(1)->Arg(2)->Arg(3)->Arg(4);

/// 85 sensors in threes: 98 770 subsets tried by KSG, all cores, with the cross-validation of the shortlist.
void hundredThousandSubsets(benchmark::State& state) {
  const SpindleRun run = RandomSpindle(1).run(patentDuty(), 100, 0.05, 0.2, 1),
                   other = RandomSpindle(2).run(patentDuty(), 100, 0.05, 0.2, 2);
  Eigen::MatrixXd t(100, 85);
  t << run.temperatures, other.temperatures.leftCols(31);
  int reports = 0;
  for (auto _ : state) {
    const SensorSelection selection = selectSensors(t, run.displacement, {}, [&](double, const std::string&) {
      ++reports;
      return true;
    });
    state.counters["subsets"] = selection.subsetsTried.back();
  }
  state.counters["reports"] = reports;
}
BENCHMARK(hundredThousandSubsets)->Unit(benchmark::kSecond)->Iterations(1)->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
