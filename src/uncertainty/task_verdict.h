#pragma once
#include <optional>
#include <string>
#include <vector>

#include "uncertainty/conformity.h"
#include "uncertainty/task_uncertainty.h"

namespace mm {

/// What a figure is held against.
struct ToleranceAsked {
  double tolerance =
      kNotMeasured;  // m: nominal ± it; of a one-sided figure the most that it may be; NaN: none
  double measured = kNotMeasured;  // m, the value that was found; NaN: the mean that is to be expected
  std::optional<PermissibleError> permissible;  // of lengths
  double permissibleProbing = kNotMeasured;     // um, of the probing error
};

struct TaskVerdict {
  Conformity conformity = Conformity::kConforms;
  std::string of;                 // the quantity, or "lengths"
  double value = 0.0, std = 0.0;  // m
  double probability = 1.0;       // that the true value is within the limits
  Specification limits;           // m
  AcceptanceZone acceptance;      // m
  bool measured = false;          // on a value that was found; else on the one that is to be expected
  std::string inWords;
};

/// Decisions by ISO 14253-1 on the headline, or on the test values of ISO 10360-2; empty: nothing was asked.
/// @throw InputError: what was asked does not go with the task.
std::vector<TaskVerdict> verdictsOf(const TaskUncertainty& result, const ToleranceAsked& asked);

/// The probing error of a test of ISO 10360-2; null: the task has none.
const QuantityUncertainty* probingOf(const TaskUncertainty& result);

/// Test values of the lengths of a task as they are to be expected.
std::vector<TestLength> testLengthsOf(const TaskUncertainty& result);

}  // namespace mm
