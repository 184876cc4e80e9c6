#include "simulation/guideway.h"

#include <cmath>

#include "base/units.h"

namespace mm {

void Straightness::apply(const Condition& condition, Distortion& distortion) const {
  direction_.add(distortion, profile_.at(condition.slide[joint_]));
}

void AngularMotion::apply(const Condition& condition, Distortion& distortion) const {
  const Eigen::Vector3d tilt = about_ * profile_.at(condition.slide[joint_]);
  if (lever_ == Lever::kWorkpiece)
    distortion.tipTilt += tilt;
  else
    distortion.tilt[joint_] += tilt;
}

void AngularReversal::apply(const Condition& condition, Distortion& distortion) const {
  distortion.tipTilt -= about_ * (0.5 * angle_ * condition.travel[joint_]);
}

void Squareness::apply(const Condition& condition, Distortion& distortion) const {
  distortion.travel[axis_] += std::tan(angle_) * condition.slide[of_];
}

void MmtAxis::apply(const Condition& condition, Distortion& distortion) const {
  const double q = condition.drive[axis_];
  double error =
      constants_.position * q + constants_.lead * q * std::sin(2.0 * kPi * q / lead_ + constants_.phase);
  for (int k = 0; k < 2; ++k) {
    const double other = condition.drive[others_[k]];
    error += constants_.straightness[k] * other * other + std::cos(0.5 * kPi + constants_.angle[k]) * other;
  }
  distortion.travel[axis_] += error;
}

}  // namespace mm
