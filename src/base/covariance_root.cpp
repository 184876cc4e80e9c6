#include "base/covariance_root.h"

#include "base/dense.h"

namespace mm {

Eigen::MatrixXd rootOfCovariance(const Eigen::MatrixXd& covariance) {
  const Eigen::Index n = covariance.rows();
  const Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      if (i != j && std[i] > 0.0 && std[j] > 0.0)
        correlation(i, j) = 0.5 * (covariance(i, j) + covariance(j, i)) / (std[i] * std[j]);
  if (n == 0) return correlation;
  const SymmetricEigen eigen(correlation);
  return std.asDiagonal() *
         (eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal() * eigen.vectors.transpose());
}

}  // namespace mm
