#include "uncertainty/residual_of.h"

namespace mm {

ResidualOf residualsOf(const CalibrationResult& fitted) {
  return [&fitted](int observation, int component) {
    const Problem& problem = *fitted.problem;
    for (int row = problem.firstRow(observation); row < problem.firstRow(observation + 1); ++row)
      if (problem.rows()[row].component == component) return fitted.residuals[row];
    return kNotMeasured;
  };
}

}  // namespace mm
