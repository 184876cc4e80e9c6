#pragma once
#include "effects/registry.h"

namespace mm {

/// thermal_network {axis, sensors, network: auto}: what a network learned of the error of one axis at the
/// positions measured, linear between them and constant beyond, from temperatures (DFNN). What it learned is
/// in the Domain; before it learned, or where it was not worth it, it has no parameters and gives nothing.
/// Composite.
EffectType thermalNetworkType();

}  // namespace mm
