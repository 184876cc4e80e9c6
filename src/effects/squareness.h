#pragma once
#include "effects/registry.h"

namespace mm {

/// `squareness {axis, of}`: c * q_of along the axis; c in m/m, m/rad …
EffectType squarenessType();

}  // namespace mm
