#pragma once
#include "effects/registry.h"

namespace mm {

/// `rotary_wobble {joint, harmonic}`: tilt motion of the axis (ISO 230-7) with h cycles a turn: cos and sin
/// of h theta about both radial directions of the fixed side; rad.
EffectType rotaryWobbleType();

}  // namespace mm
