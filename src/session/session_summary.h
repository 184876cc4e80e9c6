#pragma once
#include <string>

#include "session/session.h"

namespace mm {

/// What a session holds, in lines for people: observations, features, ranges of the joints (mm, deg),
/// temperatures, covariates, and the warning if there is one.
std::string summarize(const Session& session);

}  // namespace mm
