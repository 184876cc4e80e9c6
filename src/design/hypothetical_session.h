#pragma once
#include <string>
#include <vector>

#include "estimation/residual_space.h"
#include "session/session.h"

namespace mm {

constexpr double kCooling = 3600.0;  // s: long enough for a small machine to cool

/// What an operator may change before he measures on: the artifact is turned about the vertical through its
/// middle (rad), or touched by another stylus.
struct Stand {
  std::string placement;  // its name; empty: it stays where it was last
  double turn = 0.0;
  int stylus = -1;  // -1: the last one
};

/// What he can change; the first is nothing. Of a session without contacts nothing else.
std::vector<Stand> standsOf(const ResidualSpace& space);

/// The session, and behind it what could be measured then, in the order of time, now and after `kCooling`:
/// every ball that was touched last, from 22 sides at two speeds; of an independent instrument positions over
/// the range of each axis, in both directions at two speeds. Temperatures go back to those of the beginning
/// while it cools.
Session hypotheticalSession(const ResidualSpace& space, const Stand& stand = {});

}  // namespace mm
