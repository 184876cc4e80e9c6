#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// Where a calibration found a touched ball or point, in workpiece.
struct FoundFeature {
  std::string name;
  bool ball = true;
  Eigen::Vector3d position;  // m
  Eigen::Vector3d std;       // m; 0 when it was known
  double radius = 0.0;       // m, of a ball
  double radiusStd = 0.0;    // m; 0 when it was exact
};

/// Every feature that the session touched, with the uncertainty of the artifact's pose in it.
std::vector<FoundFeature> foundFeatures(const CalibrationResult& result);

}  // namespace mm
