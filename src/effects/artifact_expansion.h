#pragma once
#include "effects/registry.h"

namespace mm {

/// `artifact_expansion {sensor}`: position and radius of the touched feature grow by alpha * (T - 20 degC);
/// alpha in 1/K.
EffectType artifactExpansionType();

}  // namespace mm
