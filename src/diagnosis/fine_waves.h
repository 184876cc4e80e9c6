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

/// A wave of which there are more than half as many as there are places of its joint explains whatever
/// differs from place to place nearly as well as it does a wave. It says something where it takes more of an
/// arbitrary error at these places than the best of so many waves takes of one that is none (1 in 10,000).
/// @param columns of the wave, without the freedom of its shape. @param left what the others leave, with the
/// wave; both rows + priors long.
bool isBestByChance(const ResidualSpace& space, const Effect& effect, double length, const RowMatrix& columns,
                    const Eigen::VectorXd& left);

}  // namespace mm
