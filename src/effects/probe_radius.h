#pragma once
#include "effects/registry.h"

namespace mm {

/// `probe_radius {}`: the tip's effective radius is r + dr: in a contact the tip's centre is at the distance
/// R + r + dr from the ball's centre, so dr goes to the slot `distance`; the centre itself does not move. dr
/// in m.
EffectType probeRadiusType();

}  // namespace mm
