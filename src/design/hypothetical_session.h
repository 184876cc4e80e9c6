#pragma once
#include "estimation/residual_space.h"
#include "session/session.h"

namespace mm {

constexpr double kCooling = 3600.0;  // s: long enough for a small machine to cool

/// What could be measured after a session, in the order of time, now and after `kCooling`: every ball that
/// was touched, from 22 sides at two speeds; of an independent instrument positions over the range of each
/// axis, in both directions at two speeds. Temperatures go back to those of the beginning while it cools.
Session hypotheticalSession(const ResidualSpace& space);

}  // namespace mm
