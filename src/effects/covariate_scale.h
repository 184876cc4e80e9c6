#pragma once
#include "effects/registry.h"

namespace mm {

/// `covariate_scale {axis, covariate}`: k * q * (c - c0) along the axis, c0 as in `covariate_offset`; k in
/// 1/unit.
EffectType covariateScaleType();

}  // namespace mm
