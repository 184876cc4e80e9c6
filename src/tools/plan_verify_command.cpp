#include <filesystem>
#include <iostream>
#include <random>

#include "base/error.h"
#include "base/format.h"
#include "base/quantity_words.h"
#include "calibration_file/calibration_yaml.h"
#include "session/plan_selection.h"
#include "session/plan_ways.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "verification/blind_trial.h"
#include "verification/trial_orders.h"
#include "verification/verification_plan.h"

namespace mm {
namespace {

struct PlanVerifyOptions {
  std::string plan, calibration, output;
  VerificationSize size;
  bool blind = false;
  TrialSettings trial;
  CLI::Option *blocks = nullptr, *seed = nullptr;
  std::string switchOn, switchOff;  // what the controller is told
  OutputFiles files;

  std::string beside(const std::string& end) const {
    return (std::filesystem::path(output).parent_path() / std::filesystem::path(output).stem()).string() +
           end;
  }
};

void declareOutputs(PlanVerifyOptions& o) {
  o.files.input({o.plan, o.calibration});
  o.files.output("-o", o.output, FileKind::kPlan);
  if (!o.blind &&
      (o.blocks->count() > 0 || o.seed->count() > 0 || !o.switchOn.empty() || !o.switchOff.empty()))
    throw InputError("--blocks, --seed, --switch-on and --switch-off are of a blind trial: add --blind");
  if (o.switchOn.empty() != o.switchOff.empty())
    throw InputError("--switch-on and --switch-off go together: give both commands of the controller");
  if (o.blind) o.files.output("-o", o.beside(".key.yaml"), FileKind::kKey);
  if (!o.switchOn.empty())
    for (const char* state : {".A.txt", ".B.txt"}) o.files.output("-o", o.beside(state), FileKind::kOther);
  o.files.check();
}

/// Writes the key, and what switches to each state: nobody has to read in which of them the correction acts.
void writeBeside(const PlanVerifyOptions& o, const BlindTrial& trial, int measurements) {
  o.files.write(o.beside(".key.yaml"), keyYaml(trial.key));
  if (!o.switchOn.empty()) {
    o.files.write(o.beside(".A.txt"), (trial.key.on == 'A' ? o.switchOn : o.switchOff) + "\n");
    o.files.write(o.beside(".B.txt"), (trial.key.on == 'B' ? o.switchOn : o.switchOff) + "\n");
  }
  std::cout << format("%d blocks of %d measurements", o.trial.blocks, measurements) << " of " << o.plan
            << " written to " << o.output
            << "\nsmallest p of its randomisation test: " << shortNumber(smallestP(trial.key.order)) << '\n'
            << "key: " << o.beside(".key.yaml") << ", to be kept closed until mm verify --blind\n";
  if (!o.switchOn.empty())
    std::cout << "commands of the states A and B: " << o.beside(".A.txt") << ", " << o.beside(".B.txt")
              << '\n';
}

void runPlanVerify(PlanVerifyOptions& o) {
  declareOutputs(o);
  const Calibration calibration = loadCalibration(o.calibration);
  const Machine machine(calibration.urdf, calibration.machineName);
  const Plan plan = Plan::load(o.plan, machine);
  const std::vector<std::size_t> moves = verificationMoves(plan, calibration, o.size);
  const std::string name = std::filesystem::path(o.output).stem().string();
  BlindTrial trial;
  if (o.blind) {
    if (o.seed->count() == 0) o.trial.seed = std::random_device()();
    trial = blindTrial(plan, machine, moves, name, o.trial);
  }
  const std::string text = o.blind ? trial.plan : planSelection(plan, machine, moves, name);
  const Plan chosen = Plan::parse(text, o.output, {}, machine);
  warn(blockedWaysText(chosen, blockedWays(chosen, machine)));
  o.files.write(o.output, text);
  if (o.blind) return writeBeside(o, trial, chosen.measurements() / o.trial.blocks);
  std::cout << chosen.measurements() << " of " << plan.measurements() << " measurements of " << o.plan
            << " written to " << o.output << '\n';
}

}  // namespace

void addPlanVerifyCommand(CLI::App& plan, int& exitStatus) {
  auto [o, command] = addCommand<PlanVerifyOptions>(
      plan, exitStatus, runPlanVerify, "verify",
      "Select about ten places of a plan that best show whether a correction helps, for mm verify");
  command.add_option("plan", o.plan, "the plan to select moves from, YAML")->required();
  command.add_option("--calibration", o.calibration, "the calibration to verify")->required();
  standardOption(command, "--places", o.size.places, wholeNumberWithin(1, 1000),
                 "number of places: balls, postures at one ball, or positions of an instrument");
  standardOption(command, "--touches", o.size.touches, wholeNumberWithin(1, 1000),
                 "measurements of each place");
  command.add_option("-o,--output", o.output, "the plan to write")->required();
  command.add_flag("--blind", o.blind,
                   "repeat the places in blocks, with the correction on in a random half of them; the key is "
                   "written beside the plan");
  o.blocks =
      standardOption(command, "--blocks", o.trial.blocks, wholeNumberWithin(kFewestBlocks, kMostBlocks),
                     "number of blocks of a blind trial, even");
  o.seed = checkedOption(command, "--seed", o.trial.seed, anySeed(),
                         "seed of the draws of a blind trial; random by default");
  command.add_option("--switch-on", o.switchOn,
                     "command of the controller that switches the correction on; written to a file of its "
                     "state, A or B");
  command.add_option("--switch-off", o.switchOff, "command that switches it off");
  o.files.declare(command);
  command.footer(
      "Selects the moves that best show whether each axis is corrected, with which sign and from which "
      "table,\n"
      "and what has changed since the calibration.\n"
      "Example:\n"
      "  mm plan verify plate_plan.yaml --calibration plate.yaml -o verify_plan.yaml\n"
      "  mm plan verify plate_plan.yaml --calibration plate.yaml --blind -o trial.yaml");
}

}  // namespace mm
