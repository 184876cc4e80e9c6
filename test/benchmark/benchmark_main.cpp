#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/error.h"
#include "base/json_text.h"
#include "base/read_file.h"
#include "base/version.h"
#include "benchmark_counts.h"
#include "benchmark_session.h"
#include "benchmark_trial.h"
#include "model/model_spec.h"
#include "simulation/roughness.h"
#include "tools/bounds.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/program.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

struct Options {
  std::string machine = "three_axis", plan, model;
  int trials = 50, effects = 1;
  double size = 1.0;
  std::uint64_t seed = 1;
  int oracle = 0;  // sessions in which nothing is hidden; 0: no oracle
  bool verbose = false, uncatalogued = false, json = false;
  std::vector<std::string> only;
  std::string rough;
  SessionVariant variant;
};

void printUnknown(const Trial& r) {
  std::printf(" | true: %s over", r.unknown.truth.direction.c_str());
  for (std::size_t i = 0; i < r.unknown.truth.variables.size(); ++i)
    std::printf("%s %s", i > 0 ? "," : "", r.unknown.truth.variables[i].c_str());
  std::printf(" | variables %s", r.unknown.justTheVariables ? "right" : "wrong");
}

void printSession(const Trial& r, const Options& o) {
  std::printf("seed %llu: hidden", static_cast<unsigned long long>(r.seed));
  for (const std::string& h : r.hiddenText) std::printf(" %s", h.c_str());
  std::printf(" | %s:", nameOf(r.verdict).c_str());
  for (const std::string& f : r.found) std::printf(" %s", f.c_str());
  if (o.uncatalogued) printUnknown(r);
  if (r.oracleGain) std::printf(" | oracle %.1f nats", *r.oracleGain);
  std::printf(" | held-out %.3f noise, %.2f s\n", r.heldOutEnd, r.seconds);
  std::fflush(stdout);
}

int run(const Options& o) {
  const Machine machine = Machine::load(o.machine);
  TrialOptions trial;
  trial.planYaml =
      varied(readWholeFile(o.plan, "give a plan with --plan (see config/plans)"), o.plan, o.variant);
  trial.planSource = o.plan;
  trial.effects = o.effects;
  trial.size = o.size;
  trial.only = o.only;
  trial.uncatalogued = o.uncatalogued;
  trial.rough = o.rough;
  Roughness().change(o.rough, "--rough");
  if (!o.model.empty()) trial.base = loadModelSpec(o.model).effects;
  if (o.uncatalogued && o.effects != 1)
    throw InputError("--uncatalogued hides one effect a session; leave out --effects");
  if (o.uncatalogued && o.only.empty())  // one kind after the other, so that all are tried alike
    for (const UncataloguedKind& kind : uncataloguedKinds()) trial.only.push_back(kind.type);
  for (const std::string& name : o.only)
    if (o.uncatalogued != isUncatalogued(name))
      throw InputError("--only: '" + name + "' is " + (o.uncatalogued ? "not " : "") +
                       "outside the catalogue; give such names with --uncatalogued, and no others");
  if (o.oracle > 0 && o.effects != 1)
    throw InputError("--oracle asks about one hidden cause; leave out --effects, or give --effects 1");
  std::optional<Oracle> oracle;
  if (o.oracle > 0) {
    ProgressBar learning("oracle");
    oracle = oracleOf(machine, trial, o.oracle, o.seed, learning.callback());
  }
  BenchmarkCounts counts(o.effects, o.uncatalogued);
  ProgressBar bar("benchmark");
  int status = kDone;
  for (int t = 0; t < o.trials; ++t) {
    if (t > 0 && Interrupt::asked()) {
      std::cerr << "mm-benchmark: stopped by Ctrl-C after " << t << " of " << o.trials << " sessions"
                << std::endl;
      status = kStopped;  // what was counted so far is the answer
      break;
    }
    bar.show(static_cast<double>(t) / o.trials);
    const Trial r =
        runTrial(machine, trial, o.seed + static_cast<std::uint64_t>(t), oracle ? &*oracle : nullptr);
    counts.add(r);
    if (!r.notShown && !o.json && (o.verbose || !counts.good(r))) printSession(r, o);
  }
  if (!o.json) {
    std::cout << counts.text();
    return status;
  }
  nlohmann::ordered_json out = {
      {"plan", o.plan}, {"machine", o.machine},     {"rough", o.rough}, {"effects", o.effects},
      {"size", o.size}, {"trials_asked", o.trials}, {"seed", o.seed},   {"uncatalogued", o.uncatalogued}};
  out.update(counts.json());
  std::cout << jsonText(out) << '\n';
  return status;
}

void declare(CLI::App& app, Options* o) {
  app.set_version_flag("--version", std::string("mm-benchmark ") + kVersion);
  app.get_formatter()->column_width(34);
  app.add_option("--machine", o->machine, "three_axis, five_axis or the path of a URDF")
      ->capture_default_str();
  app.add_option("--plan", o->plan, "measurement plan (YAML)")->required();
  app.add_option("--model", o->model, "model file: what the diagnosis starts from; nothing if left out");
  app.add_option("--trials", o->trials, "simulated sessions")
      ->capture_default_str()
      ->check(wholeNumberWithin(1, 1'000'000));
  app.add_option("--effects", o->effects, "effects hidden in each; 0: none")
      ->capture_default_str()
      ->check(wholeNumberWithin(0, 100));
  app.add_option("--size", o->size, "RMS of what refit leaves of each, over the noise")
      ->capture_default_str()
      ->check(numberWithin(1e-6, 1e6));
  app.add_option("--only", o->only,
                 "kinds to draw from (see mm simulate --help, and uncatalogued_kinds.cpp)");
  app.add_flag(
      "--uncatalogued", o->uncatalogued,
      "hide effects outside the catalogue: unknown_effect and a profile over the right variables are wanted");
  app.add_option("--contacts", o->variant.contacts,
                 "contacts of a session, e.g. 160 or 5000; as in the plan if left out")
      ->check(wholeNumberWithin(1, 1'000'000));
  app.add_flag("--one-sided", o->variant.oneSided, "every contact from one side of x, of y and of z");
  app.add_flag("--free-centres", o->variant.freeCentres, "the balls' centres are not known");
  app.add_flag("--outliers", o->variant.outliers, "3 % of the contacts are wrong by 20 um");
  app.add_flag("--heavy-tails", o->variant.heavyTails, "noise of Student's t with three degrees of freedom");
  app.add_flag("--time-temperature", o->variant.timeTemperature,
               "the room only warms up: temperatures go with time");
  app.add_option("--stated-noise", o->variant.statedNoise,
                 "the artifact states the noise times this factor, e.g. 0.5 or 2; none: it states nothing");
  app.add_option(
      "--rough", o->rough,
      "sessions rougher than white noise: drift, correlated, form, sensors, tails, quantised, all, "
      "separated by commas (see mm simulate --help)");
  app.add_option(
         "--oracle", o->oracle,
         "also what somebody could tell who knows noise and roughness and asks about the hidden cause "
         "alone; learned from this many sessions, e.g. 200, or 2000 where balls have form errors")
      ->check(wholeNumberWithin(8, 100000));
  app.add_flag("--json", o->json, "figures and sessions as JSON on standard output");
  app.add_option("--seed", o->seed, "first seed")->capture_default_str()->check(anySeed());
  app.add_flag("--verbose", o->verbose, "a line for each session, not only for those that went wrong");
  app.footer(
      "Example: mm-benchmark --plan config/plans/nine_ball_plate.yaml --trials 100 --effects 2 --size 1\n" +
      std::string(kExitStatusHelp));
}

}  // namespace
}  // namespace mm

int main(int argc, char** argv) {
  CLI::App app{"Hides effects at random in simulated sessions and counts what the diagnosis finds.",
               "mm-benchmark"};
  mm::Options options;
  int exitStatus = mm::kDone;
  mm::declare(app, &options);
  app.callback([&] { exitStatus = mm::run(options); });
  return mm::runProgram(app, exitStatus, argc, argv);
}
