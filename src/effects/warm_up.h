#pragma once
#include "effects/registry.h"

namespace mm {

/// `warm_up {direction}`: d * (1 - exp(-t / tau)) from the session's start; d in m or rad, tau in s.
EffectType warmUpType();

}  // namespace mm
