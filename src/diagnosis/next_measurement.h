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

struct NextMeasurement {
  std::vector<Move> moves;
  struct Rival {
    bool same = false;  // it imitates the leading hypothesis wherever the machine can go
    double deviations =
        0.0;  // by which the moves tell it from the leading hypothesis, in standard deviations
  };
  std::vector<Rival> rivals;  // as asked; empty where nothing could be proposed
};

/// Feasible moves that best tell `own` from its rivals: the leading hypothesis is believed at its fitted
/// size, each rival imitates it as well as it can on the data so far, and the moves are those at which the
/// imitation fails most for its uncertainty (T-optimal design, greedily).
NextMeasurement nextMeasurement(const ResidualSpace& space, const Hypothesis& own,
                                const std::vector<Hypothesis>& rivals);

}  // namespace mm
