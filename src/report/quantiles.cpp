#include "report/quantiles.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace mm {

SizeOfResiduals sizeOfResiduals(const CalibrationResult& result, bool angular) {
  std::vector<double> sizes;
  for (int i = 0; i < result.residuals.size(); ++i)
    if (result.weight[i] > 0.0 && result.problem->rows()[static_cast<std::size_t>(i)].angular == angular)
      sizes.push_back(std::abs(result.residuals[i]));
  SizeOfResiduals size;
  size.count = static_cast<int>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  if (!sizes.empty()) size.max = sizes.back();
  for (const int percent : {50, 90, 95, 99}) {
    double value = kNotMeasured;
    if (!sizes.empty()) {  // linear between the order statistics
      const double place = 0.01 * percent * static_cast<double>(sizes.size() - 1);
      const std::size_t below = static_cast<std::size_t>(place),
                        above = std::min(below + 1, sizes.size() - 1);
      value = sizes[below] + (place - static_cast<double>(below)) * (sizes[above] - sizes[below]);
    }
    size.quantiles.emplace_back(percent, value);
  }
  return size;
}

std::string sixDigits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value == 0.0 ? 0.0 : value);
  return text;
}

}  // namespace mm
