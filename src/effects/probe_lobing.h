#pragma once
#include "effects/registry.h"

namespace mm {

/// `probe_lobing {order}`: along the approach, cos(eps) * (S sin(n phi) + K cos(n phi)); phi is the azimuth
/// of the approach about the stylus (z of probe_tip), eps its elevation from the plane across the stylus; n =
/// 2, 3, 4; S, K in m.
EffectType probeLobingType();

}  // namespace mm
