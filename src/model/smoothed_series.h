#pragma once
#include "session/session.h"

namespace mm {

/// What a slow quantity was, by readings of it that scatter: a part of a machine warms along a smooth course,
/// a sensor adds noise or rounds. The course is an integrated Wiener process, a cubic smoothing spline
/// (Wahba, J. R. Stat. Soc. B 40 (1978) 364), by a Kalman filter and a smoother; how much the readings
/// scatter against it is what makes them likeliest (Wecker and Ansley, J. Am. Stat. Assoc. 78 (1983) 81).
/// Readings that do not scatter stay as they are.
/// @param raw time ascending, s; values that are not finite stay, and are passed over.
Series smoothed(Series raw);

}  // namespace mm
