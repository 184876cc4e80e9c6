// One state compensated with the 21 constants of MMT: with and without its standard deviation.
#include <benchmark/benchmark.h>

#include "compensation/compensator.h"

namespace {

mm::Calibration mmtCalibration() {
  const mm::Machine machine = mm::Machine::load("three_axis");
  mm::Calibration c;
  c.id = "bench";
  c.machineName = machine.name();
  c.urdf = machine.urdf();
  c.domain.setMachine(machine);
  for (const mm::Joint& joint : machine.joints()) {
    c.domain.lower.push_back(joint.lower);
    c.domain.upper.push_back(joint.upper);
    c.domain.positions.emplace_back();
    c.effects.push_back(mm::EffectSpec("mmt_deviation").set("axis", joint.name).set("lead_mm", 1.0));
  }
  const mm::Model model(machine, c.domain, c.effects);
  for (int p = 0; p < model.parameterCount(); ++p)
    c.values.push_back(
        {model.effectOf(p), model.parameter(p).name, "1", 1.0, 1e-4 * (1 + p % 5), 1e-6, false});
  const auto n = static_cast<Eigen::Index>(c.values.size());
  c.covariance = 1e-12 * Eigen::MatrixXd::Identity(n, n);
  return c;
}

void compensateOneState(benchmark::State& run) {
  mm::Compensator::Options options;
  options.sigma = run.range(0) != 0;
  const mm::Compensator compensator(mmtCalibration(), options);
  mm::Compensator::Workspace work;
  mm::State state = compensator.blankState();
  double x = 0.0;
  for (auto _ : run) {
    state.position = {x = x > 0.015 ? -0.015 : x + 1e-6, 0.01, -0.004};
    compensator.model().place(state);
    benchmark::DoNotOptimize(compensator.apply(state, work));
  }
  run.SetLabel(std::to_string(compensator.model().parameterCount()) + " constants");
}
BENCHMARK(compensateOneState)->ArgName("sigma")->Arg(0)->Arg(1);

}  // namespace

BENCHMARK_MAIN();
