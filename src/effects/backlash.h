#pragma once
#include "effects/registry.h"

namespace mm {

/// `backlash {axis}`: -0.5 * gap * sign(v): the slide lags its drive; gap in m or rad is the full reversal.
EffectType backlashType();

}  // namespace mm
