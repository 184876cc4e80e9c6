#pragma once
#include "effects/registry.h"

namespace mm {

/// `mmt_deviation {axis, lead_mm, exponent: 2, amplitude_exponent: 1, argument: 2pi}`: the seven constants of
/// one axis of MMT eq. (13), with C2 and phi as S = C2 cos(phi), K = C2 sin(phi). Lengths in m, alpha in rad.
EffectType mmtDeviationType();

}  // namespace mm
