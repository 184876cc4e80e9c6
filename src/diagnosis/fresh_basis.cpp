#include "diagnosis/fresh_basis.h"

namespace mm {

Eigen::MatrixXd freshBasis(const Eigen::MatrixXd& basis, Eigen::MatrixXd columns) {
  for (int k = 0; k < columns.cols(); ++k) {
    const double norm = columns.col(k).norm();
    if (norm > 0.0) columns.col(k) /= norm;
  }
  for (int pass = 0; pass < 2; ++pass)
    if (basis.cols() > 0) columns -= basis * (basis.transpose() * columns);
  Eigen::MatrixXd fresh(columns.rows(), 0);
  for (int k = 0; k < columns.cols(); ++k) {
    Eigen::VectorXd c = columns.col(k);
    for (int pass = 0; pass < 2; ++pass)
      if (fresh.cols() > 0) c -= fresh * (fresh.transpose() * c);
    if (c.squaredNorm() < kDependent) continue;
    fresh.conservativeResize(Eigen::NoChange, fresh.cols() + 1);
    fresh.rightCols<1>() = c.normalized();
  }
  return fresh;
}

}  // namespace mm
