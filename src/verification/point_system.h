#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimation/noise_rows.h"
#include "verification/fresh_points.h"

namespace mm {

/// Fresh points whose noise is white and of size 1: the noise and its memory are found from what no error of
/// the machine could explain, and taken out of every column.
class PointSystem {
 public:
  /// @param points must outlive it. @param calibration whose drift is known beforehand.
  /// @throw NumericalError: fewer residuals than the noise needs.
  PointSystem(const FreshPoints& points, const Calibration& calibration);
  PointSystem(const PointSystem&) = delete;
  PointSystem& operator=(const PointSystem&) = delete;

  double white() const { return white_; }        ///< white noise, in units of the stated one
  double freedoms() const { return freedoms_; }  ///< residuals beyond everything that was let free
  Eigen::VectorXd variances() const;             ///< of each row's noise, in units of the stated one
  /// Columns (length x k) with unit noise.
  Eigen::MatrixXd whiten(const Eigen::MatrixXd& columns) const;
  /// Covariance of the rows' noise times m, in units of the stated noise. @param m rows x k
  Eigen::MatrixXd covarianceTimes(const Eigen::MatrixXd& m) const;
  /// Orthonormal columns of what belongs to the session, after whiten.
  const Eigen::MatrixXd& base() const { return base_; }
  /// What everything leaves: the session's own unknowns, the correction along every axis, each of its
  /// parameters, and shapes. Squared, in units of the noise; `freedoms` are left.
  double leftByAll() const { return leftByAll_; }
  double noise() const { return leftByAll_ / freedoms_; }  ///< variance, in units of the noise: about 1
  /// Rows (of FreshPoints::space) that stand apart from all the others by more than five standard
  /// deviations.
  const std::vector<int>& outliers() const { return outliers_; }

 private:
  std::vector<DriftTerm> knownDrift(const Calibration& calibration) const;
  void findOutliers(const Eigen::MatrixXd& all);

  const FreshPoints& points_;
  LinearisedRows rows_;
  NoiseModel noise_;
  std::unique_ptr<TimeWhitener> whitener_;
  double white_ = 1.0, freedoms_ = 0.0, leftByAll_ = 0.0;
  Eigen::MatrixXd base_;
  std::vector<int> outliers_;
};

/// Least squares with what is known beforehand: columns that are free, and columns whose coefficients scatter
/// about zero with standard deviation 1.
class Projection {
 public:
  Projection(const Eigen::MatrixXd& free, const Eigen::MatrixXd& scattering);
  /// What the free and the scattering columns leave of others; longer by a row a scattering column.
  Eigen::MatrixXd left(const Eigen::MatrixXd& columns) const;
  int rank() const { return basis_.cols(); }  ///< of both

 private:
  Eigen::Index scattering_ = 0;
  Eigen::MatrixXd basis_;
};

/// Matrices side by side.
Eigen::MatrixXd beside(const std::vector<Eigen::MatrixXd>& parts);

}  // namespace mm
