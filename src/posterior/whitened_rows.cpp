#include "posterior/whitened_rows.h"

#include <Eigen/Core>
#include <algorithm>

#include "estimation/row_products.h"

namespace mm {

RowMatrix fixedColumnsOf(const NoiseRows& rows, const std::vector<RandomBlock>& scatter,
                         const std::vector<double>& ratios) {
  Eigen::Index count = rows.base.cols();
  for (std::size_t b = 0; b < scatter.size(); ++b) count += ratios[b] > 0.0 ? scatter[b].columns.cols() : 0;
  RowMatrix fixed(rows.length(), count);
  fixed.leftCols(rows.base.cols()) = rows.base;
  Eigen::Index at = rows.base.cols();
  for (std::size_t b = 0; b < scatter.size(); ++b) {
    if (!(ratios[b] > 0.0)) continue;
    fixed.middleCols(at, scatter[b].columns.cols()) = ratios[b] * scatter[b].columns;
    at += scatter[b].columns.cols();
  }
  return fixed;
}

WhitenedRows::WhitenedRows(const NoiseRows& rows, const Eigen::VectorXd& variance,
                           const std::vector<DriftTerm>& drift, const std::vector<RandomBlock>& scatter,
                           const std::vector<double>& ratios)
    : whitener_(std::make_unique<TimeWhitener>(whitenerOf(rows, variance, drift))),
      fixed_(fixedColumnsOf(rows, scatter, ratios)) {
  whitener_->whiten(fixed_);
  RowMatrix target = rows.target;
  whitener_->whiten(target);
  target_ = target.col(0);
  const auto base = static_cast<int>(rows.base.cols());
  Eigen::MatrixXd products = rowProducts(fixed_);
  for (int k = 0; k < products.cols(); ++k) products(k, k) += k < base ? kRidge : 1.0;
  factor_ = Cholesky(products);
  byTarget_ = factor_.solveLower(fixed_.transpose() * target_);
  rest_ = std::max(0.0, target_.squaredNorm() - byTarget_.squaredNorm());
  logDeterminant_ = whitener_->logDeterminant() + factor_.logDeterminant();
  freedoms_ = std::max(1, rows.length() - base);
}

WhitenedRows::Columns WhitenedRows::prepare(RowMatrix columns) const {
  Columns out;
  out.whitened = std::move(columns);
  whitener_->whiten(out.whitened);
  out.byFixed = rowProducts(fixed_, out.whitened);
  factor_.solveLowerInPlace(out.byFixed);
  out.target = out.whitened.transpose() * target_ - out.byFixed.transpose() * byTarget_;
  return out;
}

Eigen::MatrixXd WhitenedRows::productOf(const Columns& a, const Columns& b) {
  return Eigen::MatrixXd(rowProducts(a.whitened, b.whitened)) - a.byFixed.transpose() * b.byFixed;
}

WhitenedRows::Joint WhitenedRows::jointOf(const std::vector<Sized>& sets, const ProductOf& product) {
  Eigen::Index count = 0;
  for (const Sized& s : sets) count += s.columns->whitened.cols();
  Eigen::MatrixXd products(count, count);
  Eigen::VectorXd target(count);
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const Sized& a = sets[i];
    const Eigen::Index n = a.columns->whitened.cols();
    target.segment(at, n) = a.size * a.columns->target;
    Eigen::Index to = 0;
    for (std::size_t j = 0; j <= i; ++j) {
      const Sized& b = sets[j];
      const Eigen::Index m = b.columns->whitened.cols();
      products.block(at, to, n, m) =
          a.size * b.size * (product ? product(i, j) : productOf(*a.columns, *b.columns));
      to += m;
    }
    at += n;
  }
  products.diagonal().array() += 1.0;
  Joint joint;
  joint.factor = Cholesky(products);
  joint.explained = joint.factor.solveLower(target);
  return joint;
}

WhitenedRows::Fit WhitenedRows::fitOf(const std::vector<Sized>& sets, const Joint& joint, double white) {
  const Eigen::VectorXd values = joint.factor.solveUpper(joint.explained);
  const Eigen::MatrixXd inverse = joint.factor.inverse();
  Fit fit;
  Eigen::Index at = 0;
  for (const Sized& s : sets) {
    const Eigen::Index k = s.columns->whitened.cols();
    fit.values.emplace_back(s.size * values.segment(at, k));
    fit.covariance.emplace_back(white * s.size * s.size * inverse.block(at, at, k, k));
    at += k;
  }
  return fit;
}

Eigen::VectorXd WhitenedRows::fixedBeside(const std::vector<Sized>& sets,
                                          const std::vector<Eigen::VectorXd>& values) const {
  Eigen::VectorXd left = byTarget_;
  for (std::size_t j = 0; j < sets.size(); ++j) left -= sets[j].columns->byFixed * values[j];
  return factor_.solveUpper(left);
}

}  // namespace mm
