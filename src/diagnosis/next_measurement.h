#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/residual_space.h"

namespace mm {

/// An effect with the values of its nonlinear parameters: one explanation of the data.
struct Hypothesis {
  EffectPtr effect;
  std::vector<double> nonlinear;
};

/// Feasible moves that best tell `own` from its rivals: the leading hypothesis is believed at its fitted
/// size, each rival imitates it as well as it can on the data so far, and the moves are those at which the
/// imitation fails most for its uncertainty (T-optimal design, greedily).
std::vector<Move> nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                  const std::vector<Hypothesis>& rivals);

}  // namespace mm
