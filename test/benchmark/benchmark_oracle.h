#pragma once
#include <Eigen/Core>

namespace mm {

/// Somebody who knows the covariance of noise and roughness, as far as sessions without a cause teach it, and
/// asks about the one cause that was hidden. Its weights come from one half of these sessions (a few strong
/// directions over a white rest), and how they scatter from the other half: what it is sure of, it may be
/// sure of. It sees less than could be seen where roughness has more directions than there are sessions, as
/// the form of many balls has: give it thousands then.
class Oracle {
 public:
  /// Log evidence (nats) from which it is sure.
  static double sure();

  /// @param noise residuals after the fit of the base model, m or rad: one column a session in which nothing
  /// is hidden, at least eight. @throw InputError where there are fewer.
  explicit Oracle(const Eigen::MatrixXd& noise);
  /// Log evidence (nats) gained by the cause. @param column what it leaves after the fit of the base model.
  /// @param residuals of the session in which it acts; both m or rad, rows as in `noise`.
  double gain(const Eigen::VectorXd& column, const Eigen::VectorXd& residuals) const;
  Eigen::Index rows() const { return check_.rows(); }

 private:
  double white_ = 0.0;      // m² or rad²: variance of the rest
  Eigen::MatrixXd strong_;  // orthonormal directions
  Eigen::VectorXd share_;   // of each that is taken out: 1 - white / variance
  Eigen::MatrixXd check_;
};

}  // namespace mm
