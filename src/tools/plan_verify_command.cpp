#include "tools/plan_verify_command.h"

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "calibration_file/calibration_yaml.h"
#include "session/plan_selection.h"
#include "session/plan_ways.h"
#include "tools/bounds.h"
#include "tools/one_line.h"
#include "tools/output_files.h"
#include "verification/verification_plan.h"

namespace mm {
namespace {

struct PlanVerifyOptions {
  std::string plan, calibration, output;
  VerificationSize size;
  OutputFiles files;
};

void runPlanVerify(PlanVerifyOptions& o) {
  o.files.input(o.plan);
  o.files.input(o.calibration);
  o.files.output("-o", o.output, FileKind::kPlan);
  o.files.check();
  const Calibration calibration = loadCalibration(o.calibration);
  const Machine machine(calibration.urdf, calibration.machineName);
  const Plan plan = Plan::load(o.plan, machine);
  const std::vector<std::size_t> moves = verificationMoves(plan, calibration, o.size);
  const std::string name = std::filesystem::path(o.output).stem().string();
  const std::string text = planSelection(plan, machine, moves, name);
  const Plan chosen = Plan::parse(text, o.output, {}, machine);
  if (const std::string ways = blockedWaysText(chosen, blockedWays(chosen, machine)); !ways.empty())
    std::cerr << "mm: warning: " << oneLine(ways) << std::endl;
  o.files.write(o.output, text);
  std::cout << chosen.measurements() << " of " << plan.measurements() << " measurements of " << o.plan
            << " written to " << o.output << '\n';
}

}  // namespace

void addPlanVerifyCommand(CLI::App& plan) {
  auto o = std::make_shared<PlanVerifyOptions>();
  CLI::App* command = plan.add_subcommand(
      "verify", "Select about ten places of a plan that best show whether a correction helps, for mm verify");
  command->add_option("plan", o->plan, "the plan to select moves from, YAML")->required();
  command->add_option("--calibration", o->calibration, "the calibration to verify")->required();
  command
      ->add_option("--places", o->size.places,
                   "number of places: balls, postures at one ball, or positions of an instrument")
      ->capture_default_str()
      ->check(wholeNumberWithin(1, 1000));
  command->add_option("--touches", o->size.touches, "measurements of each place")
      ->capture_default_str()
      ->check(wholeNumberWithin(1, 1000));
  command->add_option("-o,--output", o->output, "the plan to write")->required();
  o->files.declare(*command);
  command->footer(
      "Selects the moves that best show whether each axis is corrected, with which sign and from which "
      "table,\n"
      "and what has changed since the calibration.\n"
      "Example:\n"
      "  mm plan verify plate_plan.yaml --calibration plate.yaml -o verify_plan.yaml");
  command->callback([o] { runPlanVerify(*o); });
}

}  // namespace mm
