#pragma once
#include "effects/registry.h"

namespace mm {

/// `rotary_axis_tilt {joint, about}`: the axis of rotation is tilted about x, y or z of the joint's fixed
/// side (ISO 230-7: error of orientation); rad.
EffectType rotaryAxisTiltType();

}  // namespace mm
