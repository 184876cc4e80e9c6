#pragma once
#include "session/session.h"

namespace mm {

/// Gives every free feature without a start value (NaN) one from its contacts: the centre of the sphere
/// through the nominal tips, or their mean where they do not determine a sphere.
void startFreeFeatures(Session& session);

}  // namespace mm
