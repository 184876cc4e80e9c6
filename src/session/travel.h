#pragma once
#include <vector>

#include "session/session.h"

namespace mm {

/// Fills `travel` of each observation in the order of time: the sign of the velocity; at standstill what the
/// reader already put there, else the direction of that joint's last motion in earlier rows; 0 where never
/// known.
void deriveTravel(std::vector<Observation>& observations, int joints);

}  // namespace mm
