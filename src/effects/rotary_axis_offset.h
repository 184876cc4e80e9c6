#pragma once
#include "effects/registry.h"

namespace mm {

/// `rotary_axis_offset {joint, direction}`: the axis of rotation is displaced along x, y or z of the joint's
/// fixed side (ISO 230-7: error of location); m.
EffectType rotaryAxisOffsetType();

}  // namespace mm
