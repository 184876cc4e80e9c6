#pragma once
#include "effects/registry.h"

namespace mm {

/// `lead_screw_periodic {axis, period_mm}`: S sin(2 pi q / period) + K cos(2 pi q / period) along the axis;
/// S, K in m. The period (m) is given, or `unknown` and estimated. A rotary axis (worm wheel) takes
/// `period_deg` instead.
EffectType leadScrewPeriodicType();

}  // namespace mm
