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

/// Linear model y = offset + slopes^T x, its slopes held back by a ridge: minimises
/// |Y - model|^2 + lambda * n * |slopes of the standardised inputs|^2. The offset is not penalised.
struct RidgeModel {
  Eigen::VectorXd offset;  // outputs
  Eigen::MatrixXd slopes;  // inputs x outputs, unit of the output per unit of the input
  double lambda = 0.0;

  /// @param x a sample a row, in the unit of the samples that were learned.
  Eigen::MatrixXd evaluate(const Eigen::MatrixXd& x) const {
    return (x * slopes).rowwise() + offset.transpose();
  }
};

/// Fits samples x inputs to samples x outputs. An input that does not vary gets slope 0.
RidgeModel fitRidge(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, double lambda);

/// Cross-validated root mean square error over blocks, in the unit of y.
struct RidgeValidation {
  double lambda = 0.0;
  double rms = 0.0;
  std::vector<double> foldRms;  // one a fold
};

/// Best of the given lambdas by held-out error; of equal ones the first.
RidgeValidation validateRidge(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y,
                              const std::vector<Fold>& folds, const std::vector<double>& lambdas);

/// Relative penalties from practically none to very strong.
std::vector<double> ridgeLadder();

/// Rows of a matrix, in the order of the indices.
Eigen::MatrixXd rowsOf(const Eigen::MatrixXd& matrix, const std::vector<int>& rows);

}  // namespace mm
