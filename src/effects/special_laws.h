#pragma once
#include "effects/registry.h"

namespace mm {

// Effects that are more than a row of the catalogue (law.h): networks, what the user states.

/// `lead_screw_periodic {axis, period_mm}`: S sin(2 pi q / period) + K cos(2 pi q / period) along the axis;
/// S, K in m. The period (m) is given, or `unknown` and estimated. A rotary axis (worm wheel) takes
/// `period_deg` instead.
EffectType leadScrewPeriodicType();

/// `formula {direction, formula, start}`: one line of the user, muParser syntax, unknowns k1, k2 …
EffectType formulaType();

/// thermal_network {axis, sensors, network: auto}: what a network learned of the error of one axis at the
/// positions measured, linear between them and constant beyond, from temperatures (DFNN). What it learned is
/// in the Domain; before it learned, or where it was not worth it, it has no parameters and gives nothing.
/// Composite.
EffectType thermalNetworkType();

}  // namespace mm
