#pragma once
#include <yaml-cpp/yaml.h>

#include <string>

#include "effects/effect_spec.h"

namespace mm {

/// The effect of a map such as {type: backlash, axis: x}; older names of a type are understood. Whether the
/// type has these keys is asked when it is created. Include only in .cpp files.
/// @param source names the file in messages. @throw InputError: no map, no type, a key twice, a value that is
/// neither plain nor a list of plain values.
EffectSpec effectSpecOf(const YAML::Node& node, const std::string& source);

}  // namespace mm
