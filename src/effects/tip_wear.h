#pragma once
#include "effects/registry.h"

namespace mm {

/// `tip_wear {slows: false}`: the tip's effective radius is r - w t, t from the session's start; with `slows:
/// true` it is r - d (1 - exp(-t / tau)). w in m/s, d in m, tau in s; negative where the tip picks up
/// material. Goes to the slot `distance`, as `probe_radius` does.
EffectType tipWearType();

}  // namespace mm
