#pragma once
#include "effects/registry.h"

namespace mm {

/// `time_drift {direction}`: d * t from the session's start; d in m/s or rad/s.
EffectType timeDriftType();

}  // namespace mm
