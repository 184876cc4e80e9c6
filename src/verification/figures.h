#pragma once
#include "verification/point_system.h"
#include "verification/verify.h"

namespace mm {

/// RMS before and after the correction, and whether they differ.
struct BeforeAndAfter {
  Figure before, after;
  bool angular = false;      // in rad: there are no residuals in m
  int residuals = 0;         // of that kind
  double noise = 0.0;        // m or rad
  double improvement = 0.0;  // difference of the squares over its standard deviation
};

/// @param loaded: after is what was measured, before what the calibration expects of the uncorrected machine
/// there, with the noise of these points; else before is what was measured, after what the correction leaves.
/// @param covariance of the calibration's parameters of the machine's effects, SI.
BeforeAndAfter beforeAndAfter(const FreshPoints& points, const PointSystem& system,
                              const Eigen::MatrixXd& covariance, bool loaded);

}  // namespace mm
