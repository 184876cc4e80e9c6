#pragma once
#include "effects/registry.h"

namespace mm {

/// `thermal_growth {direction, sensor, lag: false}`: g * (T - 20 degC); with `lag: true` T goes through a
/// first-order lag of unknown time constant; g in m/K or rad/K.
EffectType thermalGrowthType();

}  // namespace mm
