#pragma once
#include "effects/registry.h"

namespace mm {

/// `thermal_expansion {axis, sensor}`: alpha * q * (T - 20 degC) along the axis; alpha in 1/K.
EffectType thermalExpansionType();

}  // namespace mm
