#pragma once
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "uncertainty/task_verdict.h"

namespace CLI {
class App;
}

namespace mm {

/// What `mm uncertainty` and `mm certificate` are told of a measurement, in the units of people.
struct UncertaintyOptions {
  std::string task, approach, mpe;
  std::vector<std::string> temperatures, joints, directions;
  TaskOptions points;
  TaskConditions conditions;
  MonteCarloOptions trials;
  unsigned threads = 0;
  double repeatabilityUm = -1.0, scale = 0.0, radiusUm = 0.0, remainderMm = -1.0, speedMm = 2.0;
  double toleranceUm = kNotMeasured, measuredMm = kNotMeasured, mpeProbingUm = kNotMeasured;

  /// Adds the options, all but the task itself.
  void declare(CLI::App& command);
  /// @param domain whose axes are named. @throw InputError naming the option, its value and an example.
  TaskConditions conditionsFor(const Domain& domain) const;
  /// Takes the unexplained remainder from the residuals of a session under the calibration.
  void foundIn(const CalibrationResult& compared, const Calibration& calibration);
  ToleranceAsked asked() const;  ///< @throw InputError, likewise
};

/// The task on machines that the calibration holds possible. @throw InputError as makeTask and
/// VirtualMachine.
TaskUncertainty taskUncertaintyOf(const Calibration& calibration, const UncertaintyOptions& options);

}  // namespace mm
