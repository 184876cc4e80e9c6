#pragma once
#include <string>
#include <vector>

#include "base/random.h"
#include "effects/domain.h"
#include "effects/effect_spec.h"
#include "effects/state.h"
#include "measuring_machine/effect_plugin.h"

namespace mm {

// The library's terms as those of a plugin, and back. SI on both sides.

/// What a plugin may know of the session.
plugin::Session sessionOf(const Domain& domain);
/// Refers to the vectors of `state`, which must outlive it.
plugin::State stateOf(const State& state);

/// The keys as the plugin takes them, complete, numbers in their shortest form (1 and 1.0 are the same).
/// @param canonical gets those that are not the plugin's standard. @throw InputError: a key that is not in
/// `allowed`, is missing, is given twice or is a list.
plugin::Keys keysOf(const EffectSpec& spec, const std::vector<plugin::Key>& allowed, EffectSpec& canonical);
EffectSpec specOf(const std::string& type, const plugin::Keys& keys);  ///< without the library's defaults

/// A state somewhere within what the session covered, to try an effect at.
State stateWithin(const Domain& domain, Random& random);

}  // namespace mm
