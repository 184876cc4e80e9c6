#pragma once
#include "effects/registry.h"

namespace mm {

/// `laser_mount {}`: mounting of the probe, LASER eq. (7), with absolute parameters that start at the nominal
/// chain: omega_B (rad) added to the reading of joint b, y32 (m) offset of joint a along y of its fixed side,
/// Q43 (m) probe zero and (l, m, n) beam direction in the frame of the last joint. Without rotary joints b
/// and a: no omega_B and y32; without a laser: no (l, m, n).
EffectType laserMountType();

}  // namespace mm
