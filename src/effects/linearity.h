#pragma once
#include <vector>

#include "effects/effect.h"
#include "effects/expression.h"
#include "effects/formula_variables.h"

namespace mm {

/// Indices of the parameters of an effect that enter linearly: all but its nonlinearParameters().
std::vector<int> linearParameters(const Effect& effect);

/// Of columns, one a parameter, those of the linear parameters.
Eigen::MatrixXd linearColumns(const Effect& effect, const Eigen::MatrixXd& all);

/// Start values of the parameters (SI), with those that enter nonlinearly at other values. @param nonlinear
/// in the order of nonlinearParameters(); those that are left out stay at their start.
std::vector<double> startsAt(const Effect& effect, const std::vector<double>& nonlinear);

/// Which unknowns of a formula enter linearly, found by trial at many random states and unknowns.
struct Linearity {
  bool linear = false;         // additive and homogeneous in all unknowns
  std::vector<int> nonlinear;  // with these held, the formula is affine in the others together
  std::vector<double>
      typicalBasis;  // linear: RMS of the formula over the samples with one unknown at 1; else empty
};

/// Fixed seed inside: the same formula gives the same answer. Where too few samples are finite, all are
/// nonlinear.
/// @param start used as the middle of the trials; may be empty.
Linearity linearityOf(const Expression& expression, const FormulaVariables& variables,
                      const std::vector<double>& start);

}  // namespace mm
