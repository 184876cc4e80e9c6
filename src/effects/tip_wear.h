#pragma once
#include "effects/registry.h"

namespace mm {

/// `tip_wear {}`: the tip's effective radius is r - w t, t from the session's start; w in m/s, negative where
/// the tip picks up material. Goes to the slot `distance`, as `probe_radius` does.
EffectType tipWearType();

}  // namespace mm
