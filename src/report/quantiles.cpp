#include "report/quantiles.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "uncertainty/task_uncertainty.h"

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
  for (const int percent : {50, 90, 95, 99})
    size.quantiles.emplace_back(percent, sizes.empty() ? kNotMeasured : quantileOf(sizes, 0.01 * percent));
  return size;
}

std::string sixDigits(double value) { return format("%.6g", value == 0.0 ? 0.0 : value); }

}  // namespace mm
