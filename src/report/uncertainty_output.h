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

/// Decimals that show two significant digits of an uncertainty; `otherwise` where there is none.
int decimalsOf(double expanded, int otherwise = 3);
/// A number with so many decimals; zero without a sign.
std::string decimalText(double value, int decimals);
/// A length in mm as its uncertainty allows, two digits of it: "28.28427".
std::string millimetres(double value, double std);
/// A positive number with two significant digits, zeros kept: "0.50", "12".
std::string twoDigits(double value);
/// A figure for people: "44.40721 mm", of a form or an error "1.31 um".
std::string figureOf(const QuantityUncertainty& q);

}  // namespace mm
