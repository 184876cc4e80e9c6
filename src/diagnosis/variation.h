#pragma once
#include "diagnosis/diagnose.h"
#include "estimation/residual_space.h"

namespace mm {

/// Effects of the model that have another shape beside the model's (a second degree, a scale), or are not the
/// same along the joint along which they are known to change: what a
/// polynomial of the third degree over that joint, times the effect, takes from what the model leaves. Told
/// where it is no chance (F test, 1 in 10,000) and at least half of `least`.
/// Causes that take as much of it with as few parameters (Schwarz's criterion, within 3 nats) are told beside
/// it.
/// @param causes that may act. @param unit m or rad of a whitened residual. @param least m or rad: noise or
/// repeatability, the larger.
std::vector<Variation> variationsOf(const ResidualSpace& space, const std::vector<CandidateResult>& causes,
                                    double unit, double least);

}  // namespace mm
