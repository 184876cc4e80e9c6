#pragma once
#include <functional>
#include <memory>
#include <string>

#include "effects/registry.h"
#include "measuring_machine/effect_plugin.h"

namespace mm {

/// Hears, one line each and each only once, what went wrong in a plugin while it was at work. May be called
/// from any thread.
using PluginTrouble = std::function<void(const std::string&)>;

/// A type of effect of the user's own as an entry of the registry. What it throws when it is created becomes
/// an InputError that names it; where it throws while it is evaluated, its inputs count as not known, and
/// `trouble` hears it. @param origin for messages: "friction_lever of package own_effect".
EffectType pluginEffectType(std::shared_ptr<const plugin::EffectType> type, const std::string& origin,
                            PluginTrouble trouble);

}  // namespace mm
