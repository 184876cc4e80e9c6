#pragma once
#include "effects/registry.h"

namespace mm {

/// `scale {axis}`: s * q along the axis; s in m/m (rad/rad).
EffectType scaleType();

}  // namespace mm
