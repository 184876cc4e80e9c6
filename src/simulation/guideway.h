#pragma once
#include "simulation/profile.h"
#include "simulation/source.h"

namespace mm {

/// A guideway that is not straight: the slide wanders sideways along its travel.
class Straightness : public Source {
 public:
  Straightness(int joint, Direction direction, Profile profile)
      : joint_(joint), direction_(direction), profile_(std::move(profile)) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Direction direction_;
  Profile profile_;
};

/// Which arm an angular error acts with.
enum class Lever {
  kWorkpiece,  // from workpiece's origin to the tip: everything that carries the probe tips
  kChain,      // from the joint on: only what the joint carries tips
};

/// Roll, pitch or yaw of a slide along its travel (ISO 230-1); it acts with its lever (Abbe).
class AngularMotion : public Source {
 public:
  /// @param about unit vector in workpiece.
  AngularMotion(int joint, Eigen::Vector3d about, Lever lever, Profile profile)
      : joint_(joint), about_(about), lever_(lever), profile_(std::move(profile)) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Eigen::Vector3d about_;
  Lever lever_;
  Profile profile_;
};

/// A slide that tips where it reverses: half the angle to either side, behind its motion.
class AngularReversal : public Source {
 public:
  /// @param about unit vector in workpiece. @param angle from one direction of travel to the other, rad.
  AngularReversal(int joint, Eigen::Vector3d about, double angle)
      : joint_(joint), about_(std::move(about)), angle_(angle) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int joint_;
  Eigen::Vector3d about_;
  double angle_;
};

/// An axis that is not square to another: travel along `of` carries the tip along `axis`.
class Squareness : public Source {
 public:
  /// @param angle rad.
  Squareness(int axis, int of, double angle) : axis_(axis), of_(of), angle_(angle) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int axis_, of_;
  double angle_;
};

/// The seven deviation constants of one axis, MMT equation (13), with the exponent 2 and the argument 2 pi.
class MmtAxis : public Source {
 public:
  struct Constants {
    double position = 0.0;                // C..1, 1
    double lead = 0.0;                    // C..2, 1: amplitude grows with the travel (exponent 1)
    double phase = 0.0;                   // rad
    double straightness[2] = {0.0, 0.0};  // C of the other axes, 1/m
    double angle[2] = {0.0, 0.0};         // alpha of the other axes, rad
  };
  /// @param first, second the two other axes in the machine's order. @param lead of the screw, m.
  MmtAxis(int axis, int first, int second, double lead, const Constants& constants)
      : axis_(axis), others_{first, second}, lead_(lead), constants_(constants) {}
  void apply(const Condition& condition, Distortion& distortion) const override;

 private:
  int axis_;
  int others_[2];
  double lead_;
  Constants constants_;
};

}  // namespace mm
