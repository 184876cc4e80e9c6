#pragma once
#include "effects/registry.h"

namespace mm {

/// `angular_motion {axis, about, degree: 1}`: rotation angle * P_n(u) of the moving part about an axis of the
/// workpiece, times the lever (roll, pitch, yaw; Abbe); n from 1 to 3; angle in rad at the end of the range.
EffectType angularMotionType();

}  // namespace mm
