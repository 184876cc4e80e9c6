#pragma once
#include "effects/registry.h"

namespace mm {

/// `formula {direction, formula, start}`: one line of the user, muParser syntax, unknowns k1, k2 …
EffectType formulaType();

}  // namespace mm
