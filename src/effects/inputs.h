#pragma once
#include <string>
#include <vector>

#include "effects/effect.h"

namespace mm {

/// What an effect depends on, found by trial: each input is varied alone at many states, and what changes the
/// error counts. So an effect of a plugin need not state it.
struct Inputs {
  std::vector<int> positions, velocities, travels;  // joints
  std::vector<int> reversals;                       // joints: on the way since their last reversal
  std::vector<int> temperatures, covariates;        // indices of the Domain
  bool time = false, approach = false, reading = false, feature = false;

  /// Its error changes while the machine stands still: by time, a temperature or a covariate.
  bool dependsOnTime() const { return time || !temperatures.empty() || !covariates.empty(); }
  bool dependsOnTemperature() const { return !temperatures.empty(); }
  /// It shows only where the direction of travel or the speed differs.
  bool needsMotion() const { return !velocities.empty() || !travels.empty(); }
};

/// Fixed seed inside: the same effect gives the same answer.
Inputs inputsOf(const Effect& effect, const Domain& domain);

}  // namespace mm
