#pragma once
#include <Eigen/Core>
#include <vector>

#include "base/dense.h"

namespace mm {

/// A drift along one direction, that forgets with a time constant. Rough: an Ornstein-Uhlenbeck
/// process (Matern 1/2); sums of these stand for a random walk, for settling and for noise that lasts from
/// contact to contact. Smooth: Matern 3/2, whose slope is continuous, as that of a part that warms and cools.
struct DriftTerm {
  int direction = 0;   // a column of the factors
  double ratio = 0.0;  // standard deviation, in units of the white noise of a row of unit variance
  double tau = 1.0;    // time constant, s
  bool smooth = false;
};

/// Time constant of a smooth drift that is like a rough one of 1.
constexpr double kSmoothTime = 0.3;

/// Correlation of such a drift with itself, `apart` (s) later. A time constant of 0 s: it remembers nothing.
double correlationOf(bool smooth, double tau, double apart);

/// A drift of unit variance from one moment to the next, `apart` (s) later: (value, slope) becomes
/// stays (value, slope) + fresh (two independent standard normal numbers).
struct DriftStep {
  DriftStep(bool smooth, double tau, double apart);
  Eigen::Matrix2d stays, fresh;
};

/// Takes the correlation in time out of rows: multiplies by L^-1, V = L L', where V is the covariance of
/// white noise and drift. A Kalman filter along the time (Rasmussen & Williams 2006, app. B; Solin & Sarkka
/// 2020): n rows and c columns cost n c terms, where V itself would cost n^2.
class TimeWhitener {
 public:
  /// @param time s, ascending, one a row. @param factors rows x directions: how much of a drift along each
  /// direction a (whitened) row sees. @param variance of the white noise a row, > 0; a very large one leaves
  /// the row out. @param sinceFirst the drift is what has changed since the first row, and nothing there;
  /// else it is at rest about an unknown mean.
  TimeWhitener(const std::vector<double>& time, const RowMatrix& factors, const Eigen::VectorXd& variance,
               const std::vector<DriftTerm>& terms, bool sinceFirst = false);

  /// Whitens the first rows of m (as many as there are times) in place; further rows stay.
  void whiten(Eigen::Ref<RowMatrix> m) const;
  /// V m, of the first rows; further rows stay.
  RowMatrix covarianceTimes(const RowMatrix& m) const;
  /// ln |V|
  double logDeterminant() const { return logDeterminant_; }
  /// What of r (a row each) is drift, in the expectation.
  Eigen::VectorXd driftIn(const Eigen::VectorXd& r) const;
  /// The same, for each term alone: rows x terms.
  Eigen::MatrixXd driftByTerm(const Eigen::VectorXd& r) const;

 private:
  /// What becomes of the state of one term over a step of time: of its value, and of its slope where it has
  /// one.
  struct Step {
    double stay = 1.0, slope = 0.0, back = 0.0, slopeStays = 1.0;
  };
  static Step stepOf(const DriftTerm& term, double dt);
  const Step& step(int row, std::size_t term) const { return steps_[row * terms_.size() + term]; }
  Eigen::VectorXd inverseTimes(const Eigen::VectorXd& r) const;  // V^-1 r
  RowMatrix covarianceOf(std::size_t term, const RowMatrix& m) const;

  bool sinceFirst_ = false;
  int rows_ = 0, states_ = 0;
  const std::vector<double>& time_;
  std::vector<DriftTerm> terms_;
  std::vector<int> first_;                  // a term: its first state
  Eigen::VectorXd variance_, inverseRoot_;  // a row; 1 / sqrt(innovation variance)
  std::vector<Step> steps_;                 // a row, a term: from the row before
  RowMatrix seen_;                          // rows x terms
  RowMatrix gain_;                          // rows x states
  double logDeterminant_ = 0.0;
};

}  // namespace mm
