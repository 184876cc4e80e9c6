#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/linearisation.h"

namespace mm {

/// The linear system of a problem at x: whitened residuals and Jacobian of the free unknowns (each divided by
/// its scale), with the priors and the norms of unit vectors as the
/// last rows.
struct WhitenedSystem {
  /// @param inverseSigma a data row: sqrt(weight) / sigma, in 1/m or 1/rad; 0 leaves the row out.
  WhitenedSystem(const Linearisation& at, const Eigen::VectorXd& inverseSigma,
                 const std::vector<char>& fixed);
  /// The same, linearised at x.
  WhitenedSystem(const Problem& problem, const Eigen::VectorXd& x, const Eigen::VectorXd& inverseSigma,
                 const std::vector<char>& fixed);

  std::vector<int> free;      // a column: the unknown
  Eigen::VectorXd scale;      // a column: SI value of one unit
  Eigen::VectorXd residuals;  // data rows, then priors, then unit vectors
  Eigen::MatrixXd jacobian;
};

}  // namespace mm
