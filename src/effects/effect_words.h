#pragma once
#include <string>

#include "effects/effect_spec.h"

namespace mm {

/// An effect as it is called in a workshop: "backlash of x", "straightness of x in z, degree 2". A type that
/// has no phrase (a plugin's) is told by its own name and keys.
std::string inWords(const EffectSpec& effect);

}  // namespace mm
