#pragma once
#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "estimation/calibrate.h"

namespace mm {

/// Shares of red, green, blue and opacity, 0 … 1.
std_msgs::ColorRGBA colourOf(double red, double green, double blue, double opaque = 1.0);
/// A marker to fill. @param frame, name its frame and namespace. @param type of visualization_msgs/Marker.
visualization_msgs::Marker markerIn(const std::string& frame, const std::string& name, int type);
/// A line of words, 2 mm high, that faces the viewer. @param at m in the frame.
visualization_msgs::Marker wordsIn(const std::string& frame, const std::string& name, const std::string& text,
                                   const Eigen::Vector3d& at);

/// Residuals for rviz: at every contact, position and deviation an arrow from where it is to where the
/// machine found it (residualVector), as in the report; balls where the calibration found them, a dot where
/// each arrow begins, outliers in red; a bar says what the arrows stand for. @param scale length of an arrow
/// over its residual; 0: such that a residual of the size of the RMS is 2 mm long. @param frame of the
/// workpiece.
visualization_msgs::MarkerArray residualMarkers(const CalibrationResult& result, double scale,
                                                const std::string& frame);

}  // namespace mm
