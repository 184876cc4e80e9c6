#include "simulation/screw.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {

double Play::after(double drive) const { return std::clamp(slide_, drive - 0.5 * gap_, drive + 0.5 * gap_); }

PeriodicLead::PeriodicLead(int joint, double amplitude, double period, double phase)
    : joint_(joint), rate_(amplitude * 2.0 * kPi / period), wave_(2.0 * kPi / period), phase_(phase) {}

void PeriodicLead::apply(const Condition& condition, Distortion& distortion) const {
  // d(error)/dq = rate * (cos(wave q + phase) + 0.2 cos(2 wave q)), integrated from 0 to q
  constexpr double kSecond = 0.2;
  const double turn = wave_ * condition.drive[joint_];
  distortion.travel[joint_] +=
      rate_ / wave_ * (std::sin(turn + phase_) - std::sin(phase_) + 0.5 * kSecond * std::sin(2.0 * turn));
}

void CumulatedLead::apply(const Condition& condition, Distortion& distortion) const {
  distortion.travel[joint_] += profile_.at(condition.drive[joint_]);
}

void ScaleError::apply(const Condition& condition, Distortion& distortion) const {
  distortion.travel[joint_] += scale_ * condition.drive[joint_];
}

}  // namespace mm
