#pragma once
#include <vector>

#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"
#include "effects/effect_spec.h"

namespace mm {

struct Round;

// A screw, gear or belt that wobbles may err at the second and third harmonic of its period as well: effects
// of their own, of the same cause.

/// Those of the model's screws, at their fitted periods. None of a screw of which the session saw less than
/// five turns: with harmonics that is any profile.
std::vector<EffectSpec> harmonicsInModel(const ResidualSpace& space);
/// Those of the screws that were found which explain more beside what was found.
std::vector<EffectSpec> harmonicsBeside(const Round& round, const Subset& found);
/// Whether every cause that was found is among those found with further candidates: harmonics refine, and
/// where another cause would go for them, many waves only imitate it.
bool keepsCauses(const Round& before, const Subset& was, const Round& after, const Subset& is);

}  // namespace mm
