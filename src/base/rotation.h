#pragma once
#include <Eigen/Geometry>

namespace mm {

/// A direction that is given shorter than this is none: rounding of a zero.
constexpr double kNoDirection = 1e-9;

/// The matrix of v x: skew(v) * w = v x w.
inline Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The rotation by a rotation vector: about its direction, by its length in rad.
inline Eigen::Matrix3d rotationBy(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  if (!(angle > 0.0)) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, vector / angle).toRotationMatrix();
}

/// The rotation vector of a rotation, rad, up to half a turn: rotationBy() of it is the rotation.
inline Eigen::Vector3d rotationVectorOf(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.axis() * turn.angle();
}

}  // namespace mm
