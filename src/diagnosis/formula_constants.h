#pragma once
#include <Eigen/Core>
#include <vector>

#include "diagnosis/formula_view.h"

namespace mm {

/// Projected columns of terms, their orthonormal basis and what they leave.
struct Solved {
  Eigen::MatrixXd basis;
  Eigen::VectorXd left;
  Eigen::VectorXd coefficients;
  double rss = 1e300;
};

/// Coefficients of terms by least squares; `rss` stays huge when a column is not finite.
Solved solve(const FormulaView& view, int direction, const std::vector<Term>& terms);

/// Scans the constants of one term that jump from datum to datum, a share of the symbol's range to both
/// sides.
void scanJumps(const FormulaView& view, int direction, std::vector<Term>& terms, std::size_t term,
               double share, Solved& best);

/// Fits the constants of all terms by Gauss-Newton; the coefficients are solved for at each step (variable
/// projection: Golub and Pereyra, 1973).
Solved fitConstants(const FormulaView& view, int direction, std::vector<Term>& terms);

}  // namespace mm
