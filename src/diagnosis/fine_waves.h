#pragma once
#include <vector>

#include "estimation/residual_space.h"

namespace mm {

/// Waves among the fine ones of an effect that the residuals prefer at a quick look: white noise, nothing
/// else there. Half as many waves over the range as there are places are the most that may be told from
/// others.
struct LikelyWaves {
  std::vector<double> lengths;  // m or rad
  int looked = 0;               // how many were looked at: what choosing among them costs
};
/// @return none for an effect without fine waves.
LikelyWaves likelyWaves(const ResidualSpace& space, const Effect& effect);

}  // namespace mm
