#pragma once
#include "effects/registry.h"

namespace mm {

/// `time_cycle {direction}`: S sin(2 pi t / P) + K cos(2 pi t / P), t from the session's start; S and K in m
/// or rad, P in s.
EffectType timeCycleType();

}  // namespace mm
