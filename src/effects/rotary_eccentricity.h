#pragma once
#include "effects/registry.h"

namespace mm {

/// `rotary_eccentricity {joint, harmonic}`: radial motion of the axis (ISO 230-7) with h cycles a turn: cos
/// and sin of h theta along both radial directions of the fixed side (m), and, as an eccentric scale gives
/// it, on the reading (rad).
EffectType rotaryEccentricityType();

}  // namespace mm
