#pragma once
#include "effects/registry.h"

namespace mm {

/// `straightness_table {axis, direction, knots}`: deviation of the axis along another direction, linear
/// between knots, from the straight line through the first and the last of them (ISO 230-1, end-point
/// reference straight line): offset belongs to the datum, slope to squareness. One value (m or rad) for each
/// knot between the ends.
EffectType straightnessTableType();

}  // namespace mm
