#pragma once
#include "effects/registry.h"

namespace mm {

/// `thermal_bending {axis, about, sensors: [a, b]}`: tilt c * (T_a - T_b) about an axis of the workpiece,
/// times the lever; `axis` names the member that bends; c in rad/K.
EffectType thermalBendingType();

}  // namespace mm
