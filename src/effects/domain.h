#pragma once
#include <limits>
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// A joint or another input whose observed range is not larger (SI) stood still: rounding of what is written
/// in mm and um.
constexpr double kStoodStill = 1e-9;

/// The part of a session that the effects need to know: what there is, and over which range it was observed.
/// All of it but `spacing` and `gaps` stands in the calibration file, so that an effect means the same later.
/// SI units.
struct Domain {
  std::vector<Joint> joints;
  int tableJoints = 0;                         // the first ones, which carry the workpiece
  std::vector<double> lower, upper;            // observed range of each joint's reading
  std::vector<std::vector<double>> positions;  // a joint: distinct positions measured (ascending, at most 64)
  std::vector<double> spacing;  // a joint: of the grid that all its positions lie on; 0: they lie on none
  std::vector<std::string> sensors;              // temperatures
  std::vector<double> sensorLower, sensorUpper;  // degC
  std::vector<std::string> covariates;
  std::vector<double> covariateLower, covariateUpper;
  std::vector<std::string> features;  // balls and points of the artifact
  std::vector<std::string> styli;     // of the probe; empty: one without a name
  int recordings = 1;                 // sessions, one after the other
  double duration = 0.0;              // s, of the longest
  std::vector<double>
      gaps;  // s, ascending: moments between the observations, of many only some; empty: not known
  double maxSpeed = 0.0;  // m/s or rad/s, largest joint velocity seen
  Eigen::Vector3d tipLower = Eigen::Vector3d::Zero(),
                  tipUpper = Eigen::Vector3d::Zero();  // box of the nominal tip, m
  std::vector<double> velocityLower, velocityUpper;    // a joint, m/s or rad/s; NaN: never known
  bool laser = false;
  double readingLower = std::numeric_limits<double>::quiet_NaN(),
         readingUpper = std::numeric_limits<double>::quiet_NaN();  // of the laser, m
  double artifactExpansion = 0.0;
  std::vector<double>
      featureRadius;  // m, a feature; 0: a point. Empty: not known, then every feature may be a ball
  Eigen::Vector3d probeZero = Eigen::Vector3d::Zero();  // nominal tip in the frame of the last joint, m
  Eigen::Matrix3d probeRotation = Eigen::Matrix3d::Identity();  // nominal axes of probe_tip in that frame

  /// Takes the joints and the probe's nominal place from the machine; what was observed stays.
  void setMachine(const Machine& machine);

  /// See spacing; 0 also where it is not known.
  double spacingOf(int joint) const;

  /// Each: the index of a name, or -1.
  int findJoint(const std::string& name) const;
  int findSensor(const std::string& name) const;
  int findCovariate(const std::string& name) const;
  int findFeature(const std::string& name) const;
  int findStylus(const std::string& name) const;
};

/// A domain without inputs but the machine's joints: each covered its travel, at five positions.
Domain domainOverTravel(const Machine& machine);

}  // namespace mm
