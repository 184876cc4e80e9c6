#pragma once
#include "effects/registry.h"

namespace mm {

/// `laser_scale {}`: s * reading of the laser; s in m/m.
EffectType laserScaleType();

}  // namespace mm
