#pragma once
#include <string>
#include <vector>

#include "effects/effect.h"

namespace mm {

/// What an effect depends on, as it answers itself: what it needs and is not known makes its contribution NaN
/// (Effect::evaluate), what has another value changes it. So an effect of a plugin need not state it.
struct Inputs {
  std::vector<int> positions, velocities, travels;  // joints
  std::vector<int> reversals;                       // joints: on the way since their last reversal
  std::vector<int> temperatures, covariates;        // indices of the Domain
  bool time = false, approach = false, reading = false, feature = false;
  bool history = false;  // of the temperatures: it lags behind one

  /// Its error changes while the machine stands still: by time, a temperature or a covariate.
  bool dependsOnTime() const { return time || !temperatures.empty() || !covariates.empty(); }
  bool dependsOnTemperature() const { return !temperatures.empty(); }
  /// It shows only where the direction of travel or the speed differs.
  bool needsMotion() const { return !velocities.empty() || !travels.empty(); }
};

/// @param domain whose joints, sensors, covariates and features are asked.
Inputs inputsOf(const Effect& effect, const Domain& domain);

}  // namespace mm
