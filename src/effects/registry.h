#pragma once
#include <functional>
#include <string>
#include <vector>

#include "effects/effect.h"

namespace mm {

/// One type of effect: how it is made from its keys, and which members of the family a diagnosis should try.
struct EffectType {
  std::string type;
  /// @throw InputError for a missing, unknown or unfit key, naming it.
  std::function<EffectPtr(const EffectSpec&, const Domain&)> create;
  /// Every member that makes sense on this machine with these inputs, whether or not the data can show it;
  /// physics restricts the list (gravity acts along the vertical, …). Empty for composites.
  std::function<std::vector<EffectSpec>(const Domain&)> candidates;
  bool composite = false;
  std::vector<std::string> keys = {};  // that it takes, in the order of the canonical form
  /// Of a row of the catalogue, all combinations of what its keys may be, whether or not they make sense.
  std::function<std::vector<EffectSpec>(const Domain&)> members = {};
  /// For the catalogue, where `candidates` are none or do not show every key: on a machine with linear joints
  /// x, y, z and rotary ones b, a.
  std::vector<EffectSpec> examples = {};
  bool valueOfEachPosition = false;  ///< it has one of its own, of the joint that its first key names
};

/// The catalogue, in its fixed order: one line an effect (registry.cpp).
const std::vector<EffectType>& effectRegistry();

/// The effect that has a value of its own at each position of a joint.
EffectSpec effectOfEachPosition(const std::string& joint);

/// Adds a type at run time (a user's plugin). @throw InputError when the name is taken.
void registerEffectType(EffectType type);

/// The name that a type has now: `cross_talk` of older files is `squareness`; any other name as it is.
std::string presentType(const std::string& type);

/// Older names of a type are understood. @throw InputError: unknown type (names the nearest known one),
/// missing or unknown keys.
EffectPtr createEffect(const EffectSpec& spec, const Domain& domain);
/// The same, with what it learned where one of the networks is its own. @throw InputError, too, as
/// Effect::taught.
EffectPtr createEffect(const EffectSpec& spec, const Domain& domain,
                       const std::vector<LearnedNetwork>& networks);

}  // namespace mm
