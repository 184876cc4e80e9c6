#include "base/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

namespace mm {
namespace {

using PivotedQr = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

PivotedQr pivotedQr(const Eigen::MatrixXd& a, double threshold) {
  PivotedQr qr(a);
  if (threshold > 0.0) qr.setThreshold(threshold);
  return qr;
}

Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> complete(const Eigen::MatrixXd& a, double threshold) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> cod;
  if (threshold > 0.0) cod.setThreshold(threshold);
  cod.compute(a);
  return cod;
}

}  // namespace

namespace dense {

void leastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  x = PivotedQr(a).solve(b);
}
void leastSquares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  x = PivotedQr(a).solve(b);
}
void shortest(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double threshold, Eigen::VectorXd& x) {
  x = complete(a, threshold).solve(b);
}
void shortest(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, double threshold, Eigen::MatrixXd& x) {
  x = complete(a, threshold).solve(b);
}
void solveSymmetric(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, Eigen::VectorXd& x) {
  x = a.ldlt().solve(b);
}
void solveSymmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& x) {
  x = a.ldlt().solve(b);
}

}  // namespace dense

Eigen::MatrixXd inverseOfSymmetric(const Eigen::MatrixXd& a) {
  return a.ldlt().solve(Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

SymmetricEigen::SymmetricEigen(const Eigen::MatrixXd& a) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(a);
  values = solver.eigenvalues();
  vectors = solver.eigenvectors();
}

Eigen::Index rankOf(const Eigen::MatrixXd& a, double threshold) { return pivotedQr(a, threshold).rank(); }

Eigen::MatrixXd spanOf(const Eigen::MatrixXd& a, double threshold) {
  const PivotedQr qr = pivotedQr(a, threshold);
  return qr.householderQ() * Eigen::MatrixXd::Identity(a.rows(), qr.rank());
}

Eigen::MatrixXd pseudoInverse(const Eigen::MatrixXd& a) { return complete(a, 0.0).pseudoInverse(); }

}  // namespace mm
