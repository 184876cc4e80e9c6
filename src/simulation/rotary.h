#pragma once
#include "simulation/source.h"

namespace mm {

/// Wrong zero of a rotary axis' encoder.
class RotaryZero : public Source {
 public:
  RotaryZero(int joint, double angle) : joint_(joint), angle_(angle) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  double angle_;  // rad
};

/// A rotary axis that does not stand where it should: shifted and tilted as a whole (ISO 230-7 location
/// errors).
class RotaryLocation : public Source {
 public:
  /// @param shift m and @param tilt rad, axes of workpiece with all joints at zero.
  RotaryLocation(int joint, Eigen::Vector3d shift, Eigen::Vector3d tilt)
      : joint_(joint), shift_(shift), tilt_(tilt) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Eigen::Vector3d shift_, tilt_;
};

/// An encoder disc mounted off its centre: the angle is wrong by (eccentricity / radius) sin(harmonic angle +
/// phase).
class DiscEccentricity : public Source {
 public:
  DiscEccentricity(int joint, int harmonic, double angle, double phase)
      : joint_(joint), harmonic_(harmonic), angle_(angle), phase_(phase) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_, harmonic_;
  double angle_, phase_;
};

/// A bearing that runs out of true: the axis goes round a small circle as it turns (ISO 230-7 radial motion).
class RadialRunOut : public Source {
 public:
  /// @param first, second two unit vectors square to the axis, in workpiece with all joints at zero.
  RadialRunOut(int joint, int harmonic, double radius, double phase, Eigen::Vector3d first,
               Eigen::Vector3d second)
      : joint_(joint), harmonic_(harmonic), radius_(radius), phase_(phase), first_(first), second_(second) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_, harmonic_;
  double radius_, phase_;
  Eigen::Vector3d first_, second_;
};

/// The axis' direction wobbles as the bearing turns.
class Wobble : public Source {
 public:
  /// @param first, second two unit vectors square to the axis, in workpiece with all joints at zero.
  Wobble(int joint, int harmonic, double angle, double phase, Eigen::Vector3d first, Eigen::Vector3d second)
      : joint_(joint), harmonic_(harmonic), angle_(angle), phase_(phase), first_(first), second_(second) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_, harmonic_;
  double angle_, phase_;
  Eigen::Vector3d first_, second_;
};

}  // namespace mm
