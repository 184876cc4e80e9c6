#include "simulation/structure.h"

#include <algorithm>
#include <cmath>

namespace mm {

void GravitySag::apply(const Condition& condition, Distortion& distortion) const {
  // end load P e^3 / (3 E I), own weight w e^4 / (8 E I): here nine parts to one at full extension
  constexpr double kOwnWeight = 0.1;
  const double e = std::max(0.0, (condition.slide[joint_] - retracted_) / length_);
  vertical_.add(distortion, -drop_ * e * e * e * ((1.0 - kOwnWeight) + kOwnWeight * e));
}

void TimeDrift::apply(const Condition& condition, Distortion& distortion) const {
  direction_.add(distortion, rate_ * condition.time);
}

void Slip::apply(const Condition& condition, Distortion& distortion) const {
  constexpr double kAfter = 0.05, kSettles = 120.0;  // of the size; s
  const double since = condition.time - at_;
  if (since >= 0.0) direction_.add(distortion, size_ * (1.0 - kAfter * std::expm1(-since / kSettles)));
}

void WarmUp::apply(const Condition& condition, Distortion& distortion) const {
  constexpr double kFastShare = 0.1, kFaster = 5.0;
  const double t = condition.time / timeConstant_;
  direction_.add(distortion,
                 size_ * ((1.0 - kFastShare) * -std::expm1(-t) + kFastShare * -std::expm1(-kFaster * t)));
}

void ScrewWarmUp::apply(const Condition& condition, Distortion& distortion) const {
  const double reached = -std::expm1(-condition.time / timeConstant_);
  distortion.travel[joint_] += strain_ * reached * (condition.drive[joint_] - fixed_);
}

void CovariateError::apply(const Condition& condition, Distortion& distortion) const {
  const double change = condition.covariates[covariate_] - reference_;
  if (axis_ >= 0)
    distortion.travel[axis_] += perUnit_ * change * condition.drive[axis_];
  else
    direction_.add(distortion, perUnit_ * change);
}

}  // namespace mm
