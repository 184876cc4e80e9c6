#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

/// One division of a series in time: fitted on `train`, judged on `test` (indices of samples).
struct Fold {
  std::vector<int> train;
  std::vector<int> test;
};

/// Divides `samples` in the order of time into `blocks` contiguous blocks, each held out once. `gap` samples
/// on both sides of the block are used for neither, so that neighbours in time do not give the answer away.
/// Throws InputError when there are fewer than 2 blocks or a fold would be empty.
std::vector<Fold> blockedFolds(int samples, int blocks, int gap = 0);

/// What a linear model with a ridge (newRidgeNetwork) leaves of held-out blocks.
struct RidgeValidation {
  double lambda = 0.0;  // the penalty that leaves least; of equal ones the smallest
  double rms = 0.0;     // cross-validated, in the unit of y
};
/// @param x samples x inputs, y samples x outputs. Penalties from practically none to very strong are tried.
RidgeValidation validateRidge(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                              const std::vector<Fold>& folds);

/// Rows of a matrix, in the order of the indices.
Eigen::MatrixXd rowsOf(const Eigen::MatrixXd& matrix, const std::vector<int>& rows);
/// Of a longer series so many samples, evenly; of another all.
std::vector<int> evenlyChosen(Eigen::Index samples, Eigen::Index most);

}  // namespace mm
