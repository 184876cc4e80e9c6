#include "base/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <utility>

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

Eigen::MatrixXd triangleOf(Eigen::MatrixXd a) {
  const Eigen::Index rows = std::min(a.rows(), a.cols());
  return Eigen::HouseholderQR<Eigen::MatrixXd>(std::move(a))
      .matrixQR()
      .topRows(rows)
      .triangularView<Eigen::Upper>();
}

Eigen::MatrixXd orthogonalParts(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(a);
  return (qr.householderQ().transpose() * b).topRows(std::min(a.rows(), a.cols()));
}

Eigen::Matrix3d nearestRotation(const Eigen::Matrix3d& a) {
  const Eigen::Vector3d turn(a(2, 1) - a(1, 2), a(0, 2) - a(2, 0), a(1, 0) - a(0, 1));
  Eigen::Matrix4d form;
  form << a.trace(), turn.transpose(), turn, a + a.transpose() - a.trace() * Eigen::Matrix3d::Identity();
  const Eigen::Vector4d q = SymmetricEigen(form).vectors.col(3);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
}

RightSingular::RightSingular(const Eigen::MatrixXd& a) {
  const Eigen::BDCSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeFullV);
  values = svd.singularValues();
  vectors = svd.matrixV();
}

Cholesky::Cholesky(const Eigen::MatrixXd& a) : lower_(a.llt().matrixL()) {}

double Cholesky::logDeterminant() const { return 2.0 * lower_.diagonal().array().log().sum(); }

Eigen::VectorXd Cholesky::solveLower(Eigen::VectorXd b) const {
  lower_.triangularView<Eigen::Lower>().solveInPlace(b);
  return b;
}
Eigen::VectorXd Cholesky::solveUpper(Eigen::VectorXd b) const {
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(b);
  return b;
}
void Cholesky::solveLowerInPlace(Eigen::MatrixXd& b) const {
  lower_.triangularView<Eigen::Lower>().solveInPlace(b);
}
void Cholesky::solveLowerInPlace(RowMatrix& b) const {
  lower_.triangularView<Eigen::Lower>().solveInPlace(b);
}
Eigen::MatrixXd Cholesky::inverse() const {
  Eigen::MatrixXd x = Eigen::MatrixXd::Identity(lower_.rows(), lower_.cols());
  lower_.triangularView<Eigen::Lower>().solveInPlace(x);
  lower_.triangularView<Eigen::Lower>().transpose().solveInPlace(x);
  return x;
}

}  // namespace mm
