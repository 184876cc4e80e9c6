#pragma once
#include "effects/registry.h"

namespace mm {

/// `covariate_offset {direction, covariate}`: k * (c - c0); k in m or rad per unit of the covariate. c0 is
/// zero, unless the observed range lies further from zero than it is wide (pressure, humidity): then it is
/// the middle of that range.
EffectType covariateOffsetType();

}  // namespace mm
