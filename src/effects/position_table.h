#pragma once
#include "effects/registry.h"

namespace mm {

/// `position_table {axis}`: one value (m or rad) for each measured position, linear between them, constant
/// beyond.
EffectType positionTableType();

}  // namespace mm
