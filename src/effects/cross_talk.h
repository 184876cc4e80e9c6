#pragma once
#include "effects/registry.h"

namespace mm {

/// `cross_talk {axis, of}`: c * q_of along the axis: squareness, deviation angle; c in m/m, m/rad …
EffectType crossTalkType();

}  // namespace mm
