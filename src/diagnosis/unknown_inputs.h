#pragma once
#include <string>

#include "effects/effect.h"
#include "estimation/problem.h"

namespace mm {

/// What an effect needs and the session does not say, of its inputs the one that is unknown at the most
/// observations: "speed is not known at 40 of 60 observations"; empty: all are known. What would show the
/// effect (Effect::shownBy) says what to record.
std::string unknownInput(const Effect& effect, const Problem& problem);

}  // namespace mm
