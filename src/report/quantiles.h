#pragma once
#include <string>
#include <utility>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// How large the residuals are, outliers set aside.
struct SizeOfResiduals {
  int count = 0;
  double max = kNotMeasured;                      // m or rad
  std::vector<std::pair<int, double>> quantiles;  // percent, of the absolute value (m or rad): 50, 90, 95, 99
};

/// @param angular the residuals in rad instead of those in m.
SizeOfResiduals sizeOfResiduals(const CalibrationResult& result, bool angular);

/// A number for people: at most six digits, no trailing zeros.
std::string sixDigits(double value);

}  // namespace mm
