#pragma once
#include "diagnosis/round.h"

namespace mm {

/// A profile that no shape of the catalogue fits leaves a rest, and effects of other causes imitate it. The
/// effects found, without those that no longer count when one cause, of these or of the model, may have any
/// smooth shape; only where that explains the session better for its number of unknowns.
Subset withoutImitators(const Round& round, const Subset& found);

}  // namespace mm
