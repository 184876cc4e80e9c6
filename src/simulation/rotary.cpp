#include "simulation/rotary.h"

#include <cmath>

namespace mm {

void RotaryZero::apply(const Condition&, Distortion& distortion) const {
  distortion.travel[joint_] += angle_;
}

void RotaryLocation::apply(const Condition&, Distortion& distortion) const {
  distortion.shift[joint_] += shift_;
  distortion.tilt[joint_] += tilt_;
}

void DiscEccentricity::apply(const Condition& condition, Distortion& distortion) const {
  distortion.travel[joint_] +=
      std::asin(std::sin(angle_) * std::sin(harmonic_ * condition.drive[joint_] + phase_));
}

void RadialRunOut::apply(const Condition& condition, Distortion& distortion) const {
  const double turn = harmonic_ * condition.slide[joint_] + phase_;
  distortion.shift[joint_] += radius_ * (std::cos(turn) * first_ + std::sin(turn) * second_);
}

void Wobble::apply(const Condition& condition, Distortion& distortion) const {
  const double turn = harmonic_ * condition.slide[joint_] + phase_;
  distortion.tilt[joint_] += angle_ * (std::cos(turn) * first_ + std::sin(turn) * second_);
}

}  // namespace mm
