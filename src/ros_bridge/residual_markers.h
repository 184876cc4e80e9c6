#pragma once
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "estimation/calibrate.h"

namespace mm {

/// Residuals for rviz: an arrow at every contact, balls where the calibration found them, contacts as dots,
/// outliers in red. @param scale length of an arrow over its residual;
/// 0: such that a residual of the size of the RMS is 2 mm long. @param frame of the workpiece.
visualization_msgs::MarkerArray residualMarkers(const CalibrationResult& result, double scale,
                                                const std::string& frame);

}  // namespace mm
