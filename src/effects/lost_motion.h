#pragma once
#include "effects/registry.h"

namespace mm {

/// `lost_motion {axis}`: -0.5 * sign(v) * (gap + (at_once - gap) * exp(-s / distance)), s the way since the
/// reversal: elastic wind-up and friction before the slide follows (ISO 230-2, reversal value; P. R. Dahl,
/// A solid friction model, 1968, whose law has at_once = -gap).
EffectType lostMotionType();

}  // namespace mm
