#pragma once
#include <string>
#include <vector>

#include "session/plan.h"

namespace mm {

/// A plan that measures some moves of another one: its artifact, speeds, clearance and simulated instrument
/// as they stand there, and the chosen moves written out. Ways around the balls are made anew when it is
/// read.
/// @param moves indices of plan.moves that measure, ascending. @param name of the new plan.
std::string planSelection(const Plan& plan, const Machine& machine, const std::vector<std::size_t>& moves,
                          const std::string& name);

/// A session of what a plan measures, on a perfect machine: every reading where it should be, as if the probe
/// had no noise. Observation i is of the move `*moves[i]`. Temperatures and covariates are not in it.
/// @param moves indices of the plan's moves; null: not wanted.
Session plannedSession(const Plan& plan, const Machine& machine, std::vector<std::size_t>* moves);

}  // namespace mm
