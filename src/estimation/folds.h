#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/drift.h"
#include "estimation/problem.h"

namespace mm {

/// Held-out folds: blocks of consecutive observations (never single contacts), dealt to the folds in turn, so
/// that each fold holds several stretches of time spread over the session. A feature of unknown position that
/// was measured in one go is not cut where a block is as long as it.
struct Folds {
  std::vector<int> ofRow;  // a data row: its fold
  std::vector<int> blockOfRow;
  int folds = 0;
  int blocks = 0;
};
/// Blocks of time in turn; consecutive contacts of a ball whose centre is free stay together.
Folds makeFolds(const Problem& problem);

/// Root mean square of the residuals that each fold has under the model fitted to the other folds, by the
/// linearised problem: e_f = (I - Q_f Q_f')^-1 r_f with Q an orthonormal basis of the Jacobian. What only the
/// fold itself can determine (a ball's centre measured nowhere else) is fitted within the fold and its
/// degrees of freedom are counted.
/// @param q rows x rank, the first rows being the data rows. @param residuals whitened, data rows first.
/// @return one held-out residual a data row (whitened).
Eigen::VectorXd heldOutResiduals(const Eigen::MatrixXd& q, const Eigen::VectorXd& residuals,
                                 const Folds& folds);

/// Where rows beside the block are left out as well: what of free columns only the judged rows determine, an
/// orthonormal basis in these (judged rows x directions).
/// @param base orthonormal columns, rows of the session and then priors. @param held a row: judged. @param
/// unused a row: judged, or neither fitted nor judged.
Eigen::MatrixXd determinedWithin(const RowMatrix& base, const std::vector<char>& held,
                                 const std::vector<char>& unused);

}  // namespace mm
