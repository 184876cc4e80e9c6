#pragma once
#include "effects/registry.h"

namespace mm {

/// `ball_radius {ball}`: the ball's radius is R + dr (slot `distance`); dr in m.
EffectType ballRadiusType();

}  // namespace mm
