#pragma once
#include "effects/registry.h"

namespace mm {

/// `laser_incidence {}`: c * (1 - cos(gamma)) on the laser's reading, gamma the angle between the beam and
/// the normal of the surface; c in m.
EffectType laserIncidenceType();

}  // namespace mm
