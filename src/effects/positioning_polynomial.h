#pragma once
#include "effects/registry.h"

namespace mm {

/// `positioning_polynomial {axis, degree}`: amplitude * P_n(u) along the axis, P_n Legendre, u the position
/// scaled to -1 … 1 over the observed range; n from 2 to 5; amplitude in m or rad.
EffectType positioningPolynomialType();

}  // namespace mm
