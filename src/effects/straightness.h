#pragma once
#include "effects/registry.h"

namespace mm {

/// `straightness {axis, direction, degree}`: amplitude * P_n(u) of the axis along another direction; n from 2
/// to 5.
EffectType straightnessType();

}  // namespace mm
