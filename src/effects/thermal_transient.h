#pragma once
#include "effects/registry.h"

namespace mm {

/// `thermal_transient {direction, sensor}`: g * (T - T'), T' the temperature T of the sensor through a
/// first-order lag of unknown time constant: what is there while a temperature changes, and goes when it
/// rests; g in m/K or rad/K.
EffectType thermalTransientType();

}  // namespace mm
