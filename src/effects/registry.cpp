#include "effects/registry.h"

#include <algorithm>

#include "effects/backlash.h"
#include "effects/cross_talk.h"
#include "effects/formula.h"
#include "effects/mmt_deviation.h"
#include "effects/nearest_name.h"
#include "effects/scale.h"
#include "effects/thermal_growth.h"
#include "machine/error.h"

namespace mm {
namespace {

std::vector<EffectType>& registry() {
  static std::vector<EffectType> types{
      mmtDeviationType(),   //
      scaleType(),          //
      crossTalkType(),      //
      backlashType(),       //
      thermalGrowthType(),  //
      formulaType(),        //
  };
  return types;
}

}  // namespace

const std::vector<EffectType>& effectRegistry() { return registry(); }

void registerEffectType(EffectType type) {
  auto& types = registry();
  if (type.type.empty() || !type.create)
    throw InputError("an effect type needs a name and a way to create it");
  if (std::any_of(types.begin(), types.end(), [&](const EffectType& t) { return t.type == type.type; }))
    throw InputError("effect type '" + type.type + "' is already in the catalogue; choose another name");
  if (!type.candidates) type.candidates = [](const Domain&) { return std::vector<EffectSpec>(); };
  types.push_back(std::move(type));
}

EffectPtr createEffect(const EffectSpec& spec, const Domain& domain) {
  std::vector<std::string> names;
  for (const EffectType& type : registry()) {
    if (type.type == spec.type) return type.create(spec, domain);
    names.push_back(type.type);
  }
  throw InputError("effect " + spec.yaml() + ": unknown type '" + spec.type + "'" +
                   didYouMean(spec.type, names) + "; known: " + listOf(names));
}

}  // namespace mm
