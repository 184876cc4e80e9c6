#pragma once
#include "effects/registry.h"

namespace mm {

/// `jump {direction, at_s}`: d from `at_s` seconds after the session's start on, nothing before; d in m or
/// rad.
EffectType jumpType();

}  // namespace mm
