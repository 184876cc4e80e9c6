#pragma once
#include "effects/state.h"

namespace mm {

/// What is known of the contact at a state: nothing is touched, the approach is known, or it should be but is
/// not.
enum class Touch { kNone, kKnown, kUnknown };

/// Whether this state touches something, and from where.
inline Touch touchOf(const State& state) {
  if (state.approach.squaredNorm() > 0.25) return Touch::kKnown;  // a unit vector; false for NaN
  return state.feature < 0 ? Touch::kNone : Touch::kUnknown;
}

}  // namespace mm
