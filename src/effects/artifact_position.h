#pragma once
#include "effects/registry.h"

namespace mm {

/// `artifact_position {feature}`: the feature is displaced by (x, y, z) in the artifact's frame; m.
EffectType artifactPositionType();

}  // namespace mm
