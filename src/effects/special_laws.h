#pragma once
#include "effects/registry.h"

namespace mm {

// Effects that are more than a row of the catalogue (law.h): tables, networks, what the user states.

/// `mmt_deviation {axis, lead_mm, exponent: 2, amplitude_exponent: 1, argument: 2pi}`: the seven constants of
/// one axis of MMT eq. (13), with C2 and phi as S = C2 cos(phi), K = C2 sin(phi). Lengths in m, alpha in rad.
EffectType mmtDeviationType();

/// `lead_screw_periodic {axis, period_mm}`: S sin(2 pi q / period) + K cos(2 pi q / period) along the axis;
/// S, K in m. The period (m) is given, or `unknown` and estimated. A rotary axis (worm wheel) takes
/// `period_deg` instead.
EffectType leadScrewPeriodicType();

/// `position_table {axis}`: one value (m or rad) for each measured position, linear between them, constant
/// beyond.
EffectType positionTableType();

/// `straightness_table {axis, direction, knots}`: deviation of the axis along another direction, linear
/// between knots, from the straight line through the first and the last of them (ISO 230-1, end-point
/// reference straight line): offset belongs to the datum, slope to squareness. One value (m or rad) for each
/// knot between the ends.
EffectType straightnessTableType();

/// `laser_mount {}`: mounting of the probe, LASER eq. (7), with absolute parameters that start at the nominal
/// chain: omega_B (rad) added to the reading of joint b, y32 (m) offset of joint a along y of its fixed side,
/// Q43 (m) probe zero and (l, m, n) beam direction in the frame of the last joint. Without rotary joints b
/// and a: no omega_B and y32; without a laser: no (l, m, n).
EffectType laserMountType();

/// `formula {direction, formula, start}`: one line of the user, muParser syntax, unknowns k1, k2 …
EffectType formulaType();

/// thermal_network {axis, sensors, network: auto}: what a network learned of the error of one axis at the
/// positions measured, linear between them and constant beyond, from temperatures (DFNN). What it learned is
/// in the Domain; before it learned, or where it was not worth it, it has no parameters and gives nothing.
/// Composite.
EffectType thermalNetworkType();

}  // namespace mm
