#pragma once
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "uncertainty/task_verdict.h"

namespace mm {

/// What `mm uncertainty --json` prints: figures in mm and um; one that does not exist is null.
std::string uncertaintyJson(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts,
                            const Calibration& calibration);
/// The same for people, in at most 100 columns.
std::string uncertaintyText(const TaskUncertainty& result, const std::vector<TaskVerdict>& verdicts);

/// A length in mm as its uncertainty allows, two digits of it: "28.28427".
std::string millimetres(double value, double std);

}  // namespace mm
