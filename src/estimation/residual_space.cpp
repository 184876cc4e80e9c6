#include "estimation/residual_space.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/distributions.h"
#include "estimation/noise_fit.h"
#include "estimation/row_products.h"
#include "estimation/thin_qr.h"
#include "estimation/whitened.h"

namespace mm {

ResidualSpace::ResidualSpace(const CalibrationResult& fitted)
    : fitted_(fitted), at_(linearise(*fitted.problem, fitted.x)) {
  const Problem& problem = *fitted.problem;
  const Folds all = makeFolds(problem);
  folds_.folds = all.folds;
  folds_.blocks = all.blocks;
  for (int i = 0; i < problem.rowCount(); ++i)
    if (fitted.weight[i] > 0.0) used_.push_back(i);
  asked_.assign(problem.session().observations.size(), 0);
  for (const int row : used_) {
    folds_.ofRow.push_back(all.ofRow[row]);
    folds_.blockOfRow.push_back(all.blockOfRow[row]);
    asked_[problem.rows()[row].observation] = 1;
  }
  inverseSigma_.resize(rows());
  for (int i = 0; i < rows(); ++i) inverseSigma_[i] = 1.0 / fitted.sigma[used_[i]];

  const WhitenedSystem system(at_, fitted.weight.cwiseSqrt().cwiseQuotient(fitted.sigma),
                              fitted.identifiability.fixed);
  const int priors = static_cast<int>(system.jacobian.rows()) - problem.rowCount();
  std::vector<int> from = used_;
  for (int i = 0; i < priors; ++i) from.push_back(problem.rowCount() + i);
  target_ = -system.residuals(from);
  q_ = orthonormalBasis(system.jacobian(from, Eigen::all));
  qRows_ = q_;
  target_ -= q_ * (q_.transpose() * target_);
}

Eigen::MatrixXd ResidualSpace::columns(const Effect& effect, const std::vector<double>& p,
                                       int* missing) const {
  Eigen::MatrixXd all = at_.effectColumns(effect, p, &asked_);
  for (int k = 0; k < all.cols(); ++k) all.col(k) *= effect.parameters()[k].scale;
  if (missing != nullptr) {
    *missing = 0;
    for (int i : used_) *missing += !all.row(i).allFinite();
  }
  return whiten(all);
}

Eigen::MatrixXd ResidualSpace::whiten(const Eigen::MatrixXd& columns) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(length(), columns.cols());
  for (int k = 0; k < columns.cols(); ++k)
    for (int i = 0; i < rows(); ++i) {
      const double v = columns(used_[i], k);
      if (std::isfinite(v)) out(i, k) = v * inverseSigma_[i];
    }
  return out;
}

void ResidualSpace::project(Eigen::MatrixXd& columns) const {
  if (q_.cols() == 0) return;
  const Eigen::MatrixXd absorbed = q_.transpose() * columns;
  columns.noalias() -= q_ * absorbed;
}

Eigen::VectorXd ResidualSpace::leftOf(const RowMatrix& columns) const {
  Eigen::VectorXd left = columns.colwise().squaredNorm();
  if (q_.cols() > 0) left -= rowProducts(qRows_, columns).colwise().squaredNorm().transpose();
  return left.cwiseMax(0.0).cwiseSqrt();
}

double ResidualSpace::mostInOneObservation(Eigen::MatrixXd columns) const {
  project(columns);
  std::vector<double> of(problem().session().observations.size(), 0.0);
  for (int i = 0; i < rows(); ++i)
    of[static_cast<std::size_t>(problem().rows()[used_[i]].observation)] += columns.row(i).squaredNorm();
  const double all = columns.topRows(rows()).squaredNorm();
  return all > 0.0 ? *std::max_element(of.begin(), of.end()) / all : 0.0;
}

double logPValueF(double f, double d1, double d2) {
  constexpr double kSmallest = -700.0;  // what a double can hold
  if (!(f > 0.0) || d1 <= 0.0 || d2 <= 0.0) return 0.0;
  const double p = fisherTail(f, d1, d2);
  return p > 0.0 ? std::max(kSmallest, std::log(p)) : kSmallest;
}

}  // namespace mm
