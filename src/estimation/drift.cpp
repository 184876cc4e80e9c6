#include "estimation/drift.h"

#include <algorithm>
#include <cmath>

namespace mm {

double correlationOf(bool smooth, double tau, double apart) {
  if (!(tau > 0.0)) return apart == 0.0 ? 1.0 : 0.0;
  if (!smooth) return std::exp(-apart / tau);
  const double a = std::sqrt(3.0) * apart / tau;
  return (1.0 + a) * std::exp(-a);
}

namespace {

/// What is left of value and slope, the slope counted in units of lambda times the value's: both then have
/// the same variance.
Eigen::Matrix2d staysOf(bool smooth, double tau, double apart) {
  Eigen::Matrix2d stays = Eigen::Matrix2d::Zero();
  if (smooth) {
    const double a = std::sqrt(3.0) * apart / tau, e = std::exp(-a);
    stays << e * (1.0 + a), e * a, -e * a, e * (1.0 - a);
  } else {
    stays(0, 0) = std::exp(-apart / tau);
  }
  return stays;
}

}  // namespace

DriftStep::DriftStep(bool smooth, double tau, double apart)
    : stays(Eigen::Matrix2d::Zero()), fresh(Eigen::Matrix2d::Identity()) {
  if (!(tau > 0.0)) return;
  stays = staysOf(smooth, tau, apart);
  // what is at rest stays at rest: F F' = I - A A'
  const Eigen::Matrix2d left = Eigen::Matrix2d::Identity() - stays * stays.transpose();
  fresh(0, 0) = std::sqrt(std::max(0.0, left(0, 0)));
  fresh(1, 0) = fresh(0, 0) > 0.0 ? left(1, 0) / fresh(0, 0) : 0.0;
  fresh(1, 1) = std::sqrt(std::max(0.0, left(1, 1) - fresh(1, 0) * fresh(1, 0)));
}

TimeWhitener::Step TimeWhitener::stepOf(const DriftTerm& term, double dt) {
  const Eigen::Matrix2d stays = staysOf(term.smooth, term.tau, dt);
  return {stays(0, 0), stays(0, 1), stays(1, 0), stays(1, 1)};
}

TimeWhitener::TimeWhitener(const std::vector<double>& time, const RowMatrix& factors,
                           const Eigen::VectorXd& variance, const std::vector<DriftTerm>& terms,
                           bool sinceFirst)
    : sinceFirst_(sinceFirst),
      rows_(static_cast<int>(time.size())),
      time_(time),
      variance_(variance),
      inverseRoot_(rows_) {
  for (const DriftTerm& t : terms)
    if (t.ratio > 0.0) {
      terms_.push_back(t);
      first_.push_back(states_);
      states_ += t.smooth ? 2 : 1;
    }
  const std::size_t count = terms_.size();
  steps_.resize(static_cast<std::size_t>(rows_) * count);
  seen_.setZero(rows_, static_cast<int>(count));
  gain_.setZero(rows_, states_);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(states_, states_);
  const auto variances = [&](auto add) {  // add(state, variance at rest)
    for (std::size_t k = 0; k < count; ++k)
      for (int s = first_[k]; s < first_[k] + (terms_[k].smooth ? 2 : 1); ++s)
        add(s, terms_[k].ratio * terms_[k].ratio);
  };
  variances([&](int s, double v) { covariance(s, s) = v; });
  if (sinceFirst)
    for (std::size_t k = 0; k < count; ++k) covariance(first_[k], first_[k]) = 0.0;
  Eigen::VectorXd spread(states_);
  for (int i = 0; i < rows_; ++i) {
    double innovation = variance_[i];
    const double dt = i > 0 ? std::max(0.0, time[i] - time[i - 1]) : 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      steps_[i * count + k] = stepOf(terms_[k], dt);
      seen_(i, static_cast<int>(k)) = factors(i, terms_[k].direction);
    }
    if (dt > 0.0 && states_ > 0) {
      // what is away from rest comes back to it: P = R + A (P - R) A'
      variances([&](int s, double v) { covariance(s, s) -= v; });
      for (int side = 0; side < 2; ++side) {
        for (std::size_t k = 0; k < count; ++k) {
          const Step& a = steps_[i * count + k];
          auto value = covariance.row(first_[k]);
          if (!terms_[k].smooth) {
            value *= a.stay;
            continue;
          }
          auto slope = covariance.row(first_[k] + 1);
          const Eigen::RowVectorXd before = value;
          value = a.stay * before + a.slope * slope;
          slope = a.back * before + a.slopeStays * slope;
        }
        covariance.transposeInPlace();
      }
      variances([&](int s, double v) { covariance(s, s) += v; });
    }
    if (states_ > 0) {
      spread.setZero();
      for (std::size_t k = 0; k < count; ++k)
        spread += seen_(i, static_cast<int>(k)) * covariance.col(first_[k]);
      for (std::size_t k = 0; k < count; ++k) innovation += seen_(i, static_cast<int>(k)) * spread[first_[k]];
      gain_.row(i) = spread.transpose() / innovation;
      covariance.noalias() -= spread * spread.transpose() / innovation;
    }
    inverseRoot_[i] = 1.0 / std::sqrt(innovation);
    logDeterminant_ += std::log(innovation);
  }
}

void TimeWhitener::whiten(Eigen::Ref<RowMatrix> m) const {
  RowMatrix state = RowMatrix::Zero(states_, m.cols());
  Eigen::RowVectorXd before(m.cols());
  for (int i = 0; i < rows_; ++i) {
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      const Step& a = step(i, k);
      auto value = state.row(first_[k]);
      if (terms_[k].smooth) {
        auto slope = state.row(first_[k] + 1);
        before = value;
        value = a.stay * before + a.slope * slope;
        slope = a.back * before + a.slopeStays * slope;
      } else {
        value *= a.stay;
      }
      const double seen = seen_(i, static_cast<int>(k));
      if (seen != 0.0) m.row(i).noalias() -= seen * value;
    }
    for (int s = 0; s < states_; ++s) state.row(s).noalias() += gain_(i, s) * m.row(i);
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
    for (int s = 0; s < states_; ++s) out[i] += gain_(i, s) * state[s];
    for (std::size_t k = 0; k < terms_.size(); ++k) {
      const Step& a = step(i, k);
      const double value = state[first_[k]] - seen_(i, static_cast<int>(k)) * out[i];
      if (terms_[k].smooth) {
        const double slope = state[first_[k] + 1];
        state[first_[k]] = a.stay * value + a.back * slope;
        state[first_[k] + 1] = a.slope * value + a.slopeStays * slope;
      } else {
        state[first_[k]] = a.stay * value;
      }
    }
  }
  return out;
}

Eigen::VectorXd TimeWhitener::driftIn(const Eigen::VectorXd& r) const {
  if (states_ == 0) return Eigen::VectorXd::Zero(rows_);
  return r.head(rows_) - variance_.cwiseProduct(inverseTimes(r));
}

RowMatrix TimeWhitener::covarianceOf(std::size_t term, const RowMatrix& m) const {
  // two passes of the kernel, which is the first element of its steps
  const int k = static_cast<int>(term);
  RowMatrix out = RowMatrix::Zero(rows_, m.cols());
  Eigen::RowVectorXd value, slope, before;
  const auto go = [&](const Step& a) {
    before = value;
    value = a.stay * before + a.slope * slope;
    slope = a.back * before + a.slopeStays * slope;
  };
  value = slope = Eigen::RowVectorXd::Zero(m.cols());
  for (int i = 0; i < rows_; ++i) {  // what came before, and the row itself
    go(step(i, term));
    value += seen_(i, k) * m.row(i);
    out.row(i) += seen_(i, k) * value;
  }
  value.setZero();
  slope.setZero();
  for (int i = rows_ - 1; i > 0; --i) {  // what comes after
    value += seen_(i, k) * m.row(i);
    go(step(i, term));
    out.row(i - 1) += seen_(i - 1, k) * value;
  }
  if (sinceFirst_ && rows_ > 0) {  // given that it is nothing at the first row
    Eigen::VectorXd first(rows_);
    for (int i = 0; i < rows_; ++i)
      first[i] = seen_(i, k) * correlationOf(terms_[term].smooth, terms_[term].tau, time_[i] - time_[0]);
    const Eigen::RowVectorXd by = first.transpose() * m.topRows(rows_);
    out.noalias() -= first * by;
  }
  return terms_[term].ratio * terms_[term].ratio * out;
}

Eigen::MatrixXd TimeWhitener::driftByTerm(const Eigen::VectorXd& r) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows_, static_cast<int>(terms_.size()));
  if (states_ == 0) return out;
  const RowMatrix x = inverseTimes(r);
  for (std::size_t k = 0; k < terms_.size(); ++k) out.col(static_cast<int>(k)) = covarianceOf(k, x);
  return out;
}

RowMatrix TimeWhitener::covarianceTimes(const RowMatrix& m) const {
  RowMatrix out = m;
  for (int i = 0; i < rows_; ++i) out.row(i) *= variance_[i];
  for (std::size_t k = 0; k < terms_.size(); ++k) out.topRows(rows_) += covarianceOf(k, m);
  return out;
}

}  // namespace mm
