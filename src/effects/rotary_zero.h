#pragma once
#include "effects/registry.h"

namespace mm {

/// `rotary_zero {joint}`: constant error of a rotary joint's reading, rad.
EffectType rotaryZeroType();

}  // namespace mm
