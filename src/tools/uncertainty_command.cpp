#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/number_text.h"
#include "base/parallel.h"
#include "base/text.h"
#include "base/units.h"
#include "calibration_file/calibration_yaml.h"
#include "report/uncertainty_output.h"
#include "tools/bounds.h"
#include "tools/commands.h"
#include "tools/exit_status.h"
#include "tools/interrupt.h"
#include "tools/progress_bar.h"
#include "uncertainty/task_verdict.h"

namespace mm {
namespace {

struct UncertaintyCommand {
  std::string calibration, task, approach, mpe;
  std::vector<std::string> temperatures, joints, directions;
  TaskOptions points;
  TaskConditions conditions;
  TrialOptions trials;
  unsigned threads = 0;
  double repeatabilityUm = -1.0, scale = 0.0, radiusUm = 0.0, remainderMm = -1.0, speedMm = 2.0;
  double toleranceUm = kNotMeasured, measuredMm = kNotMeasured, mpeProbingUm = kNotMeasured;
  bool json = false;
};

/// The two sides of `name=value`.
std::pair<std::string, std::string> assignmentOf(const std::string& text, const char* option,
                                                 const char* example) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw InputError(std::string(option) + " '" + text + "' is not name=value; write " + example);
  return {text.substr(0, at), text.substr(at + 1)};
}

double optionNumber(const std::string& text, const std::string& option, double lower, double upper,
                    const char* example) {
  double value = 0.0;
  const std::string bare(trim(text));
  if (!parseNumber(bare, value) || !(value >= lower && value <= upper))
    throw InputError(option + ": '" + bare + "' is not a number from " + numberText(lower) + " to " +
                     numberText(upper) + "; write " + example);
  return value;
}

/// "bed=21.5" or "bed=21.5+-0.2", in degC and K.
TaskConditions::Temperature temperatureOf(const std::string& text) {
  constexpr const char* kExample =
      "--temperature bed=21.5 or bed=21.5+-0.2 (degC, standard uncertainty in K)";
  const auto [sensor, value] = assignmentOf(text, "--temperature", kExample);
  TaskConditions::Temperature t;
  t.sensor = sensor;
  const std::size_t at = value.find("+-");
  t.value = optionNumber(value.substr(0, at), "--temperature " + sensor, -273.15, 1000.0, kExample);
  if (at != std::string::npos)
    t.std = optionNumber(value.substr(at + 2), "--temperature " + sensor, 0.0, 100.0, kExample);
  return t;
}

std::vector<double> listOfNumbers(const std::string& text, const std::string& option, std::size_t count,
                                  const char* example) {
  std::vector<double> values;
  std::size_t from = 0;
  for (;;) {
    const std::size_t end = text.find(',', from);
    values.push_back(optionNumber(text.substr(from, end - from), option, -1e9, 1e9, example));
    if (end == std::string::npos) break;
    from = end + 1;
  }
  if (values.size() != count)
    throw InputError(option + " '" + text + "' has " + std::to_string(values.size()) + " numbers, it needs " +
                     std::to_string(count) + "; write " + example);
  return values;
}

void readConditions(UncertaintyCommand& c, const Domain& domain) {
  TaskConditions& conditions = c.conditions;
  for (const std::string& text : c.temperatures) conditions.temperatures.push_back(temperatureOf(text));
  for (const std::string& text : c.joints) {
    const auto [name, value] = assignmentOf(text, "--joint", "--joint b=30 (deg, or mm of a linear axis)");
    const int j = domain.findJoint(name);
    const bool linear = j >= 0 && domain.joints[static_cast<std::size_t>(j)].kind == JointKind::kLinear;
    conditions.positions.push_back({name, optionNumber(value, "--joint " + name, -1e5, 1e5, "--joint b=30") *
                                              (linear ? kMillimetre : kDegree)});
  }
  for (const std::string& text : c.directions) {
    const auto [name, value] = assignmentOf(text, "--direction", "--direction x=+1 or x=-1");
    if (value != "+1" && value != "1" && value != "-1" && value != "+" && value != "-")
      throw InputError("--direction " + name + ": '" + value + "' is neither +1 nor -1");
    conditions.travel.push_back({name, value[0] == '-' ? -1.0 : 1.0});
  }
  if (!c.approach.empty()) {
    constexpr const char* kExample = "--approach 0,0,-1";
    const std::vector<double> v = listOfNumbers(c.approach, "--approach", 3, kExample);
    const Eigen::Vector3d approach(v[0], v[1], v[2]);
    if (!(approach.norm() > 0.0))
      throw InputError("--approach '" + c.approach + "' is no direction; write " + kExample);
    conditions.approach = approach.normalized();
  }
  conditions.repeatability = c.repeatabilityUm < 0.0 ? -1.0 : c.repeatabilityUm * kMicrometre;
  conditions.artifactScale = c.scale * 1e-6;
  conditions.artifactRadius = c.radiusUm * kMicrometre;
  conditions.contactSpeed = c.speedMm * kMillimetre;
  if (c.remainderMm >= 0.0) conditions.remainderLength = c.remainderMm * kMillimetre;
}

ToleranceAsked toleranceOf(const UncertaintyCommand& c) {
  ToleranceAsked asked;
  asked.tolerance = c.toleranceUm * kMicrometre;
  asked.measured = c.measuredMm * kMillimetre;
  asked.permissibleProbing = c.mpeProbingUm;
  if (c.mpe.empty()) return asked;
  constexpr const char* kExample = "--mpe 1.5,250 for 1.5 um + L/250 (L in mm)";
  const std::vector<double> v = listOfNumbers(c.mpe, "--mpe", 2, kExample);
  if (!(v[0] >= 0.0) || !(v[1] > 0.0))
    throw InputError("--mpe '" + c.mpe + "': A must not be negative, K must be above zero; write " +
                     kExample);
  asked.permissible = PermissibleError{};
  asked.permissible->a = v[0];
  asked.permissible->k = v[1];
  return asked;
}

void runUncertainty(UncertaintyCommand& c, int& exitStatus) {
  const Calibration calibration = loadCalibration(c.calibration);
  readConditions(c, calibration.domain);
  const ToleranceAsked asked = toleranceOf(c);
  const Model model(Machine(calibration.urdf, calibration.machineName), calibration.domain,
                    calibration.effects, calibration.networks);
  const std::unique_ptr<MeasurementTask> task = makeTask(c.task, c.points, model);
  const VirtualMachine machine(calibration, *task, c.conditions);
  TaskUncertainty result;
  {
    ProgressBar bar("measuring");
    c.trials.progress = [&](double share) { bar.show(share, "trials"); };
    const CancelScope cancel([] { return Interrupt::asked(); });
    Threads(c.threads).run([&] { result = taskUncertainty(*task, machine, c.trials); });
  }
  const std::vector<TaskVerdict> verdicts = verdictsOf(result, asked);
  if (c.json)
    std::cout << uncertaintyJson(result, verdicts, calibration) << '\n';
  else
    std::cout << uncertaintyText(result, verdicts);
  std::cout.flush();
  for (const std::string& note : result.notes) std::cerr << "mm: note: " << note << '\n';
  for (const std::string& why : result.outside)
    std::cerr << "mm: warning: the calibration does not hold " << why
              << "; the uncertainty is not known there\n";
  for (const TaskVerdict& v : verdicts)
    if (v.conformity != Conformity::kConforms) exitStatus = kAnswerIsNo;
  if (!result.outside.empty()) exitStatus = kAnswerIsNo;
}

void declareConditions(CLI::App& command, UncertaintyCommand& c) {
  command
      .add_option("--temperature", c.temperatures,
                  "sensor=degC, or sensor=degC+-K with its standard uncertainty (default: middle of the "
                  "calibrated range); once a sensor")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--direction", c.directions,
                  "axis=+1 or axis=-1: travel of an axis at points without a contact (default: +1)")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--joint", c.joints, "axis=deg (or mm): where an axis stands that the task does not move")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--approach", c.approach,
                     "x,y,z: direction of approach at the points of distance and position");
  command
      .add_option("--points", c.points.points,
                  "contacts on the feature, or targets of ISO 230-2 (default: as usual)")
      ->check(wholeNumberWithin(3, 1000));
  command
      .add_option("--at-s", c.conditions.time,
                  "time on the clock of the calibrated session (default: its end)")
      ->check(numberWithin(0.0, 1e9, "s"));
  command.add_option("--interval-s", c.conditions.interval, "from point to point, for the drift")
      ->check(numberWithin(0.0, 1e6, "s"))
      ->capture_default_str();
  command.add_option("--speed-mm-s", c.speedMm, "of the approach")
      ->check(numberWithin(0.001, 1e4, "mm/s"))
      ->capture_default_str();
  command
      .add_option("--margin", c.conditions.margin,
                  "how far beyond the calibrated range it holds, as a fraction")
      ->check(numberWithin(0.0, 10.0))
      ->capture_default_str();
  command
      .add_option("--repeatability-um", c.repeatabilityUm, "of the probe (default: that of the calibration)")
      ->check(numberWithin(0.0, 1e6, "um"));
  command.add_option("--artifact-scale-um-m", c.scale, "standard uncertainty of the artifact's scale, um/m")
      ->check(numberWithin(0.0, 1e6, "um/m"));
  command
      .add_option("--artifact-radius-um", c.radiusUm,
                  "standard uncertainty of the radius of the ball on which the tip was qualified")
      ->check(numberWithin(0.0, 1e6, "um"));
  command
      .add_option(
          "--remainder-length-mm", c.remainderMm,
          "over which the unexplained remainder changes (default: a quarter of the volume's diagonal)")
      ->check(numberWithin(0.0, 1e6, "mm"));
}

void declareDecision(CLI::App& command, UncertaintyCommand& c) {
  command.add_option("--quantity", c.trials.quantity,
                     "figure of the task that is asked (default: its first)");
  command
      .add_option("--tolerance-um", c.toleranceUm,
                  "+- about the nominal value; of a form or a range its limit")
      ->check(numberWithin(0.0, 1e6, "um"));
  command.add_option("--measured-mm", c.measuredMm, "value that was found (default: as is to be expected)")
      ->check(numberWithin(-1e6, 1e6, "mm"));
  command.add_option("--mpe", c.mpe, "A,K: maximum permissible error A um + L/K of lengths (L in mm)");
  command.add_option("--mpe-probing-um", c.mpeProbingUm, "maximum permissible probing error")
      ->check(numberWithin(0.0, 1e6, "um"));
  command.add_option("--seed", c.trials.seed, "of the random numbers")
      ->check(anySeed())
      ->capture_default_str();
  command
      .add_option("--trials", c.trials.trials,
                  "so many (default: until the digits are stable, GUM Supplement 1, 7.9)")
      ->check(wholeNumberWithin(100, 100000000));
  command.add_option("--digits", c.trials.digits, "of the standard uncertainty that must be stable")
      ->check(wholeNumberWithin(1, 2))
      ->capture_default_str();
  command.add_option("--threads", c.threads, "0: one a core; the result does not depend on it")
      ->check(wholeNumberWithin(0, 1024));
  command.add_flag("--json", c.json, "one JSON object instead of text");
}

}  // namespace

void addUncertaintyCommand(CLI::App& app, int& exitStatus) {
  auto c = std::make_shared<UncertaintyCommand>();
  CLI::App* command = app.add_subcommand(
      "uncertainty", "How uncertain a measurement on the calibrated machine is, and by what");
  command->add_option("calibration", c->calibration, "the calibration file")->required();
  command->add_option("--task", c->task, "what is measured, see below")->required();
  declareConditions(*command, *c);
  declareDecision(*command, *c);
  command->footer(
      "Tasks (mm, workpiece):\n" + taskHelp() +
      "Machines that the calibration holds possible measure the task (GUM Supplement 1, ISO/TS 15530-4).\n"
      "Verdicts by ISO 14253-1; where the calibration does not hold, or one is not \"conforms\": exit 1.\n"
      "Example: mm uncertainty c.yaml --task distance:0,0,0:15,10,0 --temperature bed=21.5");
  command->callback([c, &exitStatus] { runUncertainty(*c, exitStatus); });
}

}  // namespace mm
