#pragma once
#include "effects/registry.h"

namespace mm {

/// `gravity_sag {direction, with, power}`: k * (extension of a linear joint from its observed minimum)^power
/// along the vertical; power 2 (load that moves out) or 3 (end of a cantilever); k in m/m^power.
EffectType gravitySagType();

}  // namespace mm
