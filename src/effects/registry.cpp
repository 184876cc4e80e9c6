#include "effects/registry.h"

#include <algorithm>

#include "base/error.h"
#include "base/nearest_name.h"
#include "effects/effect_words.h"
#include "effects/law.h"
#include "effects/owned.h"
#include "effects/profile.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

/// In the order of words.yaml.
std::vector<EffectType> catalogue() {
  std::vector<EffectType> types = {leadScrewPeriodicType(), formulaType(), profileType(),
                                   thermalNetworkType()};
  for (const auto& rows : {lawsOfAxes(), lawsOfTemperature(), lawsOfTime(), lawsOfContact(),
                           lawsOfRotaryAxes(), lawsOfTables(), lawsOfPapers()})
    for (const LawRow& row : rows) types.push_back(lawType(row));
  const std::vector<std::string> order = typesInWords();
  const auto placeOf = [&](const EffectType& type) {
    return std::find(order.begin(), order.end(), type.type) - order.begin();
  };
  std::sort(types.begin(), types.end(),
            [&](const EffectType& a, const EffectType& b) { return placeOf(a) < placeOf(b); });
  return types;
}

std::vector<EffectType>& registry() {
  static std::vector<EffectType> types = catalogue();
  return types;
}

}  // namespace

const std::vector<EffectType>& effectRegistry() { return registry(); }

EffectSpec effectOfEachPosition(const std::string& joint) {
  const auto type = std::find_if(registry().begin(), registry().end(),
                                 [](const EffectType& t) { return t.valueOfEachPosition; });
  return EffectSpec(type->type).set(type->keys.front(), joint);
}

std::string presentType(const std::string& type) { return type == "cross_talk" ? "squareness" : type; }

void registerEffectType(EffectType type) {
  auto& types = registry();
  if (type.type.empty() || !type.create)
    throw InputError("an effect type needs a name and a way to create it");
  if (std::any_of(types.begin(), types.end(),
                  [&](const EffectType& t) { return t.type == presentType(type.type); }))
    throw InputError("effect type '" + type.type + "' is already in the catalogue; choose another name");
  if (!type.candidates) type.candidates = [](const Domain&) { return std::vector<EffectSpec>(); };
  types.push_back(std::move(type));
}

EffectPtr createEffect(const EffectSpec& given, const Domain& domain) {
  EffectSpec spec = given;
  spec.type = presentType(given.type);
  const Owner owner = takeOwner(spec);
  std::vector<std::string> names;
  for (const EffectType& type : registry()) {
    if (type.type == spec.type) {
      EffectPtr law = type.create(spec, domain);
      return owner.isMachine() ? law : ownedEffect(std::move(law), owner, domain);
    }
    names.push_back(type.type);
  }
  throw InputError("effect " + spec.yaml() + ": unknown type '" + spec.type + "'" +
                   didYouMean(spec.type, names) + "; known: " + listOf(names) +
                   "; an effect of your own needs its package on ROS_PACKAGE_PATH (source its setup.bash)");
}

EffectPtr createEffect(const EffectSpec& spec, const Domain& domain,
                       const std::vector<LearnedNetwork>& networks) {
  EffectPtr effect = createEffect(spec, domain);
  if (!effect->nature().learned) return effect;
  const std::string own = effect->spec().yaml();
  for (const LearnedNetwork& network : networks)
    if (network.effect == own) return effect->taught(network, domain);
  return effect;
}

}  // namespace mm
