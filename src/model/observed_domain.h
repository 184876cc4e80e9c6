#pragma once
#include "effects/domain.h"
#include "session/session.h"

namespace mm {

/// What a session observed and over which range: the part of it that the effects need and a calibration
/// keeps. Ranges of temperatures and covariates are those at the observations; NaN for one that was never
/// logged then. Positions of a joint are distinct when more than 1 um or 1e-6 rad apart; more than 64 of them
/// are not listed.
Domain observedDomain(const Session& session);

}  // namespace mm
