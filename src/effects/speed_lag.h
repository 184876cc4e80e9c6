#pragma once
#include "effects/registry.h"

namespace mm {

/// `speed_lag {}`: -tau * v of every joint: a trigger that is late by tau (s) reads too far.
EffectType speedLagType();

}  // namespace mm
