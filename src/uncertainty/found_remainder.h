#pragma once
#include <Eigen/Core>
#include <optional>

#include "estimation/calibrate.h"

namespace mm {

/// What a model does not explain, beyond noise and drift, in each coordinate of workpiece. Standard
/// deviations, m.
struct Remainder {
  Eigen::Vector3d smooth = Eigen::Vector3d::Zero();  // changes over `length`
  Eigen::Vector3d rough = Eigen::Vector3d::Zero();   // from contact to contact
  double length = 0.0;                               // m, of exp(-d^2 / 2 length^2)
  double places = 0.0;  // independent ones that tell `smooth`: its degrees of freedom
};

/// Finds it from held-out residuals. The product of two residuals has the expectation sum_k f_ik f_jk s_k^2
/// rho(d_ij) beside that of the drift, f being the direction cosines of the residuals and d the distance of
/// the places: least squares of the products of nearby residuals, with variances that are not negative, gives
/// the smooth part (method of moments, as a variogram is fitted; Cressie 1993, 2.4). What the squares have
/// beyond it and the stated noise is the rough part. A field of correlation rho over n rows tells its
/// variance like n^2 / sum rho^2 independent values (Bayley and Hammersley 1946).
/// @param length m; it is not estimated. @return empty: no residuals in m, or fewer than twelve.
std::optional<Remainder> remainderOf(const CalibrationResult& result, double length);

}  // namespace mm
