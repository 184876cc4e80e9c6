#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/problem.h"

namespace mm {

/// Columns of a Jacobian that are zero outside a few rows of their own: the centre of one free ball.
struct LocalBlock {
  std::vector<int> rows, columns;
};

/// The blocks of the features whose position is unknown. @param jacobian its first rows are the problem's,
/// others (priors) follow. @param unknowns of its columns.
std::vector<LocalBlock> localBlocks(const Problem& problem, const Eigen::MatrixXd& jacobian,
                                    const std::vector<int>& unknowns);

/// Householder QR of a tall matrix: column order[k] of it is q * r.col(k).
struct ThinQr {
  Eigen::MatrixXd q;       // rows x columns, orthonormal columns; empty unless asked for
  Eigen::MatrixXd r;       // columns x columns, upper triangular
  std::vector<int> order;  // of the columns

  /// r with its columns in the order of the matrix.
  Eigen::MatrixXd rInOrder() const;
};

/// Eliminates the blocks first, each within its own rows: the rest is dense in the few columns that all rows
/// share.
/// @param jacobian at least as many rows as columns. @param blocks disjoint in rows and in columns.
ThinQr thinQr(const Eigen::MatrixXd& jacobian, const std::vector<LocalBlock>& blocks, bool wantQ);

/// Orthonormal basis of what the columns span. A column that is zero, or that those before it span but for
/// rounding, adds none: its remainder would be a direction of chance that absorbs whatever lies along it.
Eigen::MatrixXd orthonormalBasis(Eigen::MatrixXd columns);

}  // namespace mm
