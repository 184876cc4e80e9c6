#include "estimation/drift.h"

#include <algorithm>
#include <cmath>

namespace mm {

TimeWhitener::TimeWhitener(const std::vector<double>& time, const RowMatrix& factors,
                           const Eigen::VectorXd& variance, const std::vector<DriftTerm>& terms)
    : rows_(static_cast<int>(time.size())), time_(time), variance_(variance), inverseRoot_(rows_) {
  for (const DriftTerm& t : terms)
    if (t.ratio > 0.0) terms_.push_back(t);
  states_ = static_cast<int>(terms_.size());
  decay_.setZero(rows_, states_);
  seen_.setZero(rows_, states_);
  gain_.setZero(rows_, states_);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(states_, states_);
  for (int k = 0; k < states_; ++k) covariance(k, k) = terms_[k].ratio * terms_[k].ratio;
  for (int i = 0; i < rows_; ++i) {
    double innovation = variance_[i];
    if (states_ > 0) {
      const double dt = i > 0 ? std::max(0.0, time[i] - time[i - 1]) : 0.0;
      for (int k = 0; k < states_; ++k) {
        decay_(i, k) = i > 0 ? std::exp(-dt / terms_[k].tau) : 1.0;
        seen_(i, k) = factors(i, terms_[k].direction);
      }
      if (dt > 0.0)
        for (int k = 0; k < states_; ++k) {
          for (int l = 0; l < states_; ++l) covariance(k, l) *= decay_(i, k) * decay_(i, l);
          covariance(k, k) += terms_[k].ratio * terms_[k].ratio * -std::expm1(-2.0 * dt / terms_[k].tau);
        }
      const Eigen::VectorXd spread = covariance * seen_.row(i).transpose();
      innovation += seen_.row(i).dot(spread);
      gain_.row(i) = spread.transpose() / innovation;
      covariance.noalias() -= spread * spread.transpose() / innovation;
    }
    inverseRoot_[i] = 1.0 / std::sqrt(innovation);
    logDeterminant_ += std::log(innovation);
  }
}

void TimeWhitener::whiten(Eigen::Ref<RowMatrix> m) const {
  RowMatrix state = RowMatrix::Zero(states_, m.cols());
  for (int i = 0; i < rows_; ++i) {
    for (int k = 0; k < states_; ++k) {
      state.row(k) *= decay_(i, k);
      if (seen_(i, k) != 0.0) m.row(i).noalias() -= seen_(i, k) * state.row(k);
    }
    for (int k = 0; k < states_; ++k) state.row(k).noalias() += gain_(i, k) * m.row(i);
    m.row(i) *= inverseRoot_[i];
  }
}

Eigen::VectorXd TimeWhitener::inverseTimes(const Eigen::VectorXd& r) const {
  RowMatrix u = r.head(rows_);
  whiten(u);
  // the adjoint of the filter, backwards
  Eigen::VectorXd out(rows_);
  Eigen::VectorXd state = Eigen::VectorXd::Zero(states_);
  for (int i = rows_ - 1; i >= 0; --i) {
    out[i] = u(i, 0) * inverseRoot_[i];
    for (int k = 0; k < states_; ++k) out[i] += gain_(i, k) * state[k];
    for (int k = 0; k < states_; ++k) state[k] = decay_(i, k) * (state[k] - seen_(i, k) * out[i]);
  }
  return out;
}

Eigen::VectorXd TimeWhitener::driftIn(const Eigen::VectorXd& r) const {
  if (states_ == 0) return Eigen::VectorXd::Zero(rows_);
  return r.head(rows_) - variance_.cwiseProduct(inverseTimes(r));
}

Eigen::MatrixXd TimeWhitener::driftByTerm(const Eigen::VectorXd& r) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows_, states_);
  if (states_ == 0) return out;
  // a term's covariance with the rows, times V^-1 r: two passes of the exponential kernel
  const Eigen::VectorXd x = inverseTimes(r);
  for (int k = 0; k < states_; ++k) {
    double forward = 0.0;
    Eigen::VectorXd sum(rows_);
    for (int i = 0; i < rows_; ++i) {
      forward = forward * decay_(i, k) + seen_(i, k) * x[i];
      sum[i] = forward;
    }
    double backward = 0.0;
    for (int i = rows_ - 1; i >= 0; --i) {
      sum[i] += backward;
      backward = (backward + seen_(i, k) * x[i]) * decay_(i, k);
    }
    out.col(k) = terms_[k].ratio * terms_[k].ratio * sum.cwiseProduct(seen_.col(k));
  }
  return out;
}

RowMatrix TimeWhitener::covarianceTimes(const RowMatrix& m) const {
  RowMatrix out = m;
  for (int i = 0; i < rows_; ++i) out.row(i) *= variance_[i];
  for (int k = 0; k < states_; ++k) {
    const double variance = terms_[k].ratio * terms_[k].ratio;
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(m.cols());
    for (int i = 0; i < rows_; ++i) {  // what came before, and the row itself
      sum = sum * decay_(i, k) + seen_(i, k) * m.row(i);
      out.row(i) += variance * seen_(i, k) * sum;
    }
    sum.setZero();
    for (int i = rows_ - 1; i > 0; --i) {  // what comes after
      sum = (sum + seen_(i, k) * m.row(i)) * decay_(i, k);
      out.row(i - 1) += variance * seen_(i - 1, k) * sum;
    }
  }
  return out;
}

}  // namespace mm
