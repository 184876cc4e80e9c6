#include <chrono>
#include <iomanip>
#include <iostream>
#include <memory>

#include "base/error.h"
#include "base/names_of.h"
#include "export/export_axes.h"
#include "interpreters/loaded_compensation.h"
#include "session/plan_ways.h"
#include "session/session_summary.h"
#include "simulation/session_csv.h"
#include "simulation/simulate.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "tools/progress_bar.h"
#include "verification/blind_trial.h"

namespace mm {
namespace {

struct SimulateOptions {
  std::string machine = "three_axis", plan, output, csv, truth, compensation, key;
  SimulationRequest request;
  OutputFiles files;
};

/// What the controller adds by its files, as their interpreter reads them. @return null unless there are any.
/// @throw InputError, it and what it returns: they do not fit this machine, or need what it does not have.
ControllerAdds addsOf(const ControllerCompensation& compensation, const Machine& machine) {
  const std::shared_ptr<const LoadedCompensation> loaded = loadedCompensation(compensation);
  if (!loaded) return {};
  const std::vector<double> anywhere(machine.joints().size(), 0.0);
  const std::vector<ExportAxis> axes = exportAxes(machine, loaded->description().letters, anywhere, anywhere);
  return [loaded, axes](const std::vector<double>& command, const std::vector<double>& travel,
                        const std::map<std::string, double>& temperatures) {
    CommandedState state;
    state.temperature = temperatures;
    for (const ExportAxis& axis : axes) {
      state.position[axis.letter] = command[axis.joint];
      state.direction[axis.letter] = static_cast<int>(travel[axis.joint]);
    }
    std::map<std::string, double> found;
    try {
      found = loaded->adds(state);
    } catch (const InputError& e) {
      throw InputError(std::string("--compensation: ") + e.what() + "; sensors are those of the plan");
    }
    std::vector<double> added(command.size(), 0.0);
    for (const ExportAxis& axis : axes)
      if (const auto value = found.find(axis.letter); value != found.end()) added[axis.joint] = value->second;
    return added;
  };
}

void runSimulate(SimulateOptions& options) {
  options.files.input({options.plan, options.machine, options.key});
  options.files.bag("-o", options.output, "simulated");
  options.files.output("--csv", options.csv, FileKind::kTable);
  options.files.output("--truth", options.truth, FileKind::kTruth);
  options.files.check();
  const ControllerCompensation compensation = statedCompensation("--compensation", options.compensation);
  const auto started = std::chrono::steady_clock::now();
  const Machine machine = Machine::load(options.machine);
  const Plan plan = Plan::load(options.plan, machine);
  warn(blockedWaysText(plan, blockedWays(plan, machine)));
  options.request.correction = addsOf(compensation, machine);
  if (!options.key.empty()) {
    if (!options.request.correction)
      throw InputError(
          "--key says in which blocks the controller corrects: give its tables with --compensation");
    const TrialKey key = loadKey(options.key);
    checkKey(key, allNames(plan.placements), options.plan, options.key);
    options.request.correctedState = key.on;
  }
  ProgressBar measuring("measuring");
  Simulation simulation = simulate(machine, plan, options.request, measuring.callback());
  if (options.key.empty()) simulation.session.compensation = compensation;  // else it was on and off
  const std::chrono::duration<double> lasted = std::chrono::steady_clock::now() - started;
  if (simulation.session.observations.empty())
    throw InputError(options.plan + ": nothing was measured: all " + std::to_string(simulation.missed) +
                     " moves missed the artifact or the laser's range");
  {
    ProgressBar writing("writing");
    options.files.write(options.output, simulation.session, writing.callback(), simulation.motion);
  }
  if (!options.csv.empty()) options.files.write(options.csv, sessionCsv(simulation.session));
  if (!options.truth.empty()) options.files.write(options.truth, truthYaml(simulation, options.request));

  const double hours = simulation.session.observations.back().time / 3600.0;
  std::cout << summarize(simulation.session);
  if (simulation.missed > 0)
    std::cout << simulation.missed << " moves measured nothing (missed, out of range, dropped out)\n";
  std::cout << std::fixed << std::setprecision(2) << hours << " h of measuring simulated in "
            << lasted.count() << " s, seed " << options.request.seed
            << ", sources hidden: " << simulation.hidden.size() << '\n'
            << "written to " << options.output << '\n';
  if (!options.truth.empty()) std::cout << "what was hidden: " << options.truth << '\n';
}

}  // namespace

void addSimulateCommand(CLI::App& app, int& exitStatus) {
  auto [options, command] = addCommand<SimulateOptions>(
      app, exitStatus, runSimulate, "simulate", "Simulate the measurement of a plan, faster than real time");
  command.add_option("--machine", options.machine, "three_axis, five_axis or the path of a URDF")->required();
  command.add_option("--plan", options.plan, "measurement plan, YAML; see config/plans")->required();
  repeatedOption(command, "--hide", options.request.hide,
                 "effect that the simulated machine has: backlash, backlash:x=3um, random (see below); "
                 "repeatable");
  command.add_option("--rough", options.request.rough,
                     "disturbances in addition to white noise, separated by commas: drift, correlated, "
                     "form, sensors, tails, "
                     "quantised, all (see below)");
  command.add_option(
      "--compensation", options.compensation,
      "what the simulated controller has loaded, and corrects by: none, or the folder with its "
      "tables, as mm export wrote it or as an interpreter reads it [not stated]");
  command.add_option(
      "--key", options.key,
      "key of a blind trial (mm plan verify --blind): the controller corrects in the blocks with the "
      "correction on");
  seedOption(command, options.request.seed);
  command.add_option("-o,--output", options.output, "the session's bag")->required();
  command.add_option("--csv", options.csv, "also write the session as CSV in the format of mm import");
  command.add_option("--truth", options.truth,
                     "write the hidden effects as YAML; the bag does not contain them");
  options.files.declare(command);
  std::string kinds;
  for (const SourceKind& kind : sourceKinds()) {
    std::string places;
    for (const SourceKind::KeyRule& key : kind.keys)
      if (key.standard.empty()) places += (places.empty() ? ":" : "/") + key.name;
    kinds += "  " + kind.type + places + "\n";
  }
  command.footer(
      "Effects for --hide (=size and ,key=value set values; the others are drawn at random from the "
      "seed):\n" +
      kinds +
      "Disturbances for --rough; a size (drift=2) is a multiple of the repeatability, default 1:\n"
      "  drift       every joint drifts slowly, unrelated to any sensor; the size is the RMS over the "
      "session\n"
      "  correlated  the noise of successive readings has a correlation of 0.7\n"
      "  form        balls with form, radius and centre errors\n"
      "  sensors     temperatures with noise, steps, offsets and lags of 30 to 300 s\n"
      "  tails       noise follows Student's t with three degrees of freedom; 1 % of the readings are gross "
      "errors\n"
      "  quantised   readings are rounded to steps, by default 3 times the repeatability\n"
      "  all         all of these except quantised\n"
      "Examples:\n"
      "  mm simulate --machine three_axis --plan config/plans/nine_ball_plate.yaml --hide random --seed 7 -o "
      "s.bag\n"
      "  mm simulate --machine three_axis --plan config/plans/nine_ball_plate.yaml --hide "
      "straightness:x/z=2um \\\n"
      "     --hide '{type: backlash, axis: x, gap: 3um}' --truth t.yaml -o s.bag");
}

}  // namespace mm
