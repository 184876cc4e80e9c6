#include "tools/uncertainty_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/bounds.h"
#include "tools/interrupt.h"
#include "workflow/recalibration.h"

namespace mm {
namespace {

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

void declareConditions(CLI::App& command, UncertaintyOptions& c) {
  repeatedOption(command, "--temperature", c.temperatures,
                 "sensor=degC, or sensor=degC+-K with its standard uncertainty (default: middle of the "
                 "calibrated range); repeatable");
  repeatedOption(command, "--direction", c.directions,
                 "axis=+1 or axis=-1: direction of travel at points without a contact (default: +1)");
  repeatedOption(command, "--joint", c.joints,
                 "axis=deg (or mm): position of an axis that the task does not move");
  command.add_option("--approach", c.approach,
                     "x,y,z: direction of approach for the tasks distance and position");
  checkedOption(command, "--points", c.points.points, wholeNumberWithin(3, 1000),
                "number of contacts on the feature, or of ISO 230-2 targets (default: by task)");
  checkedOption(command, "--at-s", c.conditions.time, numberWithin(0.0, 1e9, "s"),
                "time on the clock of the calibrated session (default: its end)");
  standardOption(command, "--interval-s", c.conditions.interval, numberWithin(0.0, 1e6, "s"),
                 "time from point to point, for the drift");
  standardOption(command, "--speed-mm-s", c.speedMm, numberWithin(0.001, 1e4, "mm/s"), "of the approach");
  standardOption(command, "--margin", c.conditions.margin, numberWithin(0.0, 10.0),
                 "margin beyond the calibrated range within which it is valid, as a fraction of the range");
  checkedOption(command, "--repeatability-um", c.repeatabilityUm, numberWithin(0.0, 1e6, "um"),
                "repeatability of the probe (default: that of the calibration)");
  checkedOption(command, "--artifact-scale-um-m", c.scale, numberWithin(0.0, 1e6, "um/m"),
                "standard uncertainty of the artifact's scale, um/m");
  checkedOption(command, "--artifact-radius-um", c.radiusUm, numberWithin(0.0, 1e6, "um"),
                "standard uncertainty of the radius of the ball on which the tip was qualified");
  checkedOption(command, "--remainder-length-mm", c.remainderMm, numberWithin(0.0, 1e6, "mm"),
                "correlation length of the unexplained error (default: a quarter of the volume's diagonal)");
}

void declareDecision(CLI::App& command, UncertaintyOptions& c) {
  command.add_option("--quantity", c.trials.quantity,
                     "quantity of the task to evaluate (default: its first)");
  checkedOption(command, "--tolerance-um", c.toleranceUm, numberWithin(0.0, 1e6, "um"),
                "tolerance +- about the nominal value; for form or range, the upper limit");
  checkedOption(command, "--measured-mm", c.measuredMm, numberWithin(-1e6, 1e6, "mm"),
                "measured value (default: the expected value)");
  command.add_option("--mpe", c.mpe,
                     "A,K[,B]: maximum permissible error A um + L/K of lengths (L in mm), at most B um");
  checkedOption(command, "--mpe-probing-um", c.mpeProbingUm, numberWithin(0.0, 1e6, "um"),
                "maximum permissible probing error");
  seedOption(command, c.trials.seed);
  checkedOption(command, "--trials", c.trials.trials, wholeNumberWithin(100, 100000000),
                "number of trials (default: until the digits are stable, GUM Supplement 1, 7.9)");
  standardOption(command, "--digits", c.trials.digits, wholeNumberWithin(1, 2),
                 "number of digits of the standard uncertainty that must be stable");
  checkedOption(command, "--threads", c.threads, wholeNumberWithin(0, 1024),
                "number of threads; 0: one per core; does not affect the result");
}

}  // namespace

void UncertaintyOptions::declare(CLI::App& command) {
  declareConditions(command, *this);
  declareDecision(command, *this);
}

TaskConditions UncertaintyOptions::conditionsFor(const Domain& domain) const {
  TaskConditions given = conditions;
  for (const std::string& text : temperatures) given.temperatures.push_back(temperatureOf(text));
  for (const std::string& text : joints) {
    const auto [name, value] = assignmentOf(text, "--joint", "--joint b=30 (deg, or mm of a linear axis)");
    const int j = domain.findJoint(name);
    const bool linear = j >= 0 && domain.joints[static_cast<std::size_t>(j)].kind == JointKind::kLinear;
    given.positions.push_back({name, optionNumber(value, "--joint " + name, -1e5, 1e5, "--joint b=30") *
                                         (linear ? kMillimetre : kDegree)});
  }
  for (const std::string& text : directions) {
    const auto [name, value] = assignmentOf(text, "--direction", "--direction x=+1 or x=-1");
    if (value != "+1" && value != "1" && value != "-1" && value != "+" && value != "-")
      throw InputError("--direction " + name + ": '" + value + "' is neither +1 nor -1");
    given.travel.push_back({name, value[0] == '-' ? -1.0 : 1.0});
  }
  if (!approach.empty()) {
    constexpr const char* kExample = "--approach 0,0,-1";
    const std::vector<double> v = listOfNumbers(approach, "--approach", 3, kExample);
    const Eigen::Vector3d way(v[0], v[1], v[2]);
    if (!(way.norm() > 0.0))
      throw InputError("--approach '" + approach + "' is not a direction; write " + kExample);
    given.approach = way.normalized();
  }
  given.repeatability = repeatabilityUm < 0.0 ? -1.0 : repeatabilityUm * kMicrometre;
  given.artifactScale = scale * 1e-6;
  given.artifactRadius = radiusUm * kMicrometre;
  given.contactSpeed = speedMm * kMillimetre;
  if (remainderMm >= 0.0) given.remainderLength = remainderMm * kMillimetre;
  return given;
}

void UncertaintyOptions::foundIn(const CalibrationResult& compared, const Calibration& calibration) {
  conditions.remainder = remainderOf(
      compared, remainderMm >= 0.0 ? remainderMm * kMillimetre : usualRemainderLength(calibration.domain));
}

ToleranceAsked UncertaintyOptions::asked() const {
  ToleranceAsked held;
  held.tolerance = toleranceUm * kMicrometre;
  held.measured = measuredMm * kMillimetre;
  held.permissibleProbing = mpeProbingUm;
  if (mpe.empty()) return held;
  constexpr const char* kExample = "--mpe 1.5,250 for 1.5 um + L/250 (L in mm)";
  const std::size_t given = std::count(mpe.begin(), mpe.end(), ',') == 2 ? 3 : 2;
  const std::vector<double> v = listOfNumbers(mpe, "--mpe", given, kExample);
  if (!(v[0] >= 0.0) || !(v[1] > 0.0) || (given == 3 && !(v[2] > 0.0)))
    throw InputError("--mpe '" + mpe + "': A must not be negative, K and B must be above zero; write " +
                     kExample);
  held.permissible = PermissibleError{};
  held.permissible->a = v[0];
  held.permissible->k = v[1];
  if (given == 3) held.permissible->b = v[2];
  return held;
}

TaskUncertainty taskUncertaintyOf(const Calibration& calibration, const UncertaintyOptions& options) {
  const TaskConditions conditions = options.conditionsFor(calibration.domain);
  const Model model = modelOf(calibration);
  TaskOptions how = options.points;
  how.permissible = options.asked().permissible;
  const std::unique_ptr<MeasurementTask> task = makeTask(options.task, how, model);
  const VirtualMachine machine(calibration, *task, conditions);
  TaskUncertainty result;
  const CancelScope cancel(Interrupt::asked);
  Threads(options.threads).run([&] { result = taskUncertainty(*task, machine, options.trials); });
  return result;
}

}  // namespace mm
