#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

namespace mm {

/// What the errors of the simulated instrument depend on at one instant. SI units, degC; vectors in
/// workpiece.
struct Condition {
  double time = 0.0;
  std::vector<double> drive;     // the readings: position of each drive, m or rad
  std::vector<double> slide;     // the drive's position less the play, m or rad
  std::vector<double> velocity;  // of each drive, m/s or rad/s
  std::vector<double> travel;    // of each drive, -1 or +1: direction of its last motion; 0: none yet
  std::vector<double> bodies;    // temperature of each body of the ThermalModel
  std::vector<double> covariates;
};

/// The errors at one instant, added up over all sources. Vectors at a joint are in the axes of workpiece with
/// all joints at zero, and act on the joint's side towards the bed. Units: m, rad.
struct Distortion {
  /// Nothing distorted. @param joints of the machine.
  explicit Distortion(int joints)
      : travel(joints, 0.0), shift(joints, Eigen::Vector3d::Zero()), tilt(joints, Eigen::Vector3d::Zero()) {}
  std::vector<double> travel;  // true travel of a slide beyond what its drive says
  std::vector<Eigen::Vector3d> shift, tilt;
  Eigen::Vector3d tipShift = Eigen::Vector3d::Zero();  // in workpiece
  Eigen::Vector3d tipTilt =
      Eigen::Vector3d::Zero();  // of everything that carries the probe, about workpiece's origin
  Eigen::Vector3d probeShift = Eigen::Vector3d::Zero();  // axes of probe_tip
  Eigen::Vector3d beamTilt = Eigen::Vector3d::Zero();    // change of the beam's direction, axes of probe_tip
};

/// One physical cause of error: adds its share. Safe to call from several threads.
using Source = std::function<void(const Condition& condition, Distortion& distortion)>;

/// Where a displacement goes: along a joint's own motion, or along x, y or z of workpiece.
struct Direction {
  int joint = -1;      // or
  int component = -1;  // 0, 1, 2
  /// Adds an error along this direction. @param amount m, or rad of a rotary joint.
  void add(Distortion& distortion, double amount) const {
    if (joint >= 0)
      distortion.travel[joint] += amount;
    else
      distortion.tipShift[component] += amount;
  }
};

/// Where a small rotation goes: what a joint carries tips, or everything that carries the probe tips about
/// workpiece's origin. It acts with its lever (Abbe).
struct Tilt {
  int joint = -1;         // -1: everything
  Eigen::Vector3d about;  // unit vector in workpiece
  /// Adds a rotation. @param angle rad.
  void add(Distortion& distortion, double angle) const {
    (joint >= 0 ? distortion.tilt[joint] : distortion.tipTilt) += about * angle;
  }
};

}  // namespace mm
