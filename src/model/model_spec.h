#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "effects/effect_spec.h"

namespace mm {

/// What a model file says: `machine: M`, `effects: [ {type: …}, … ]`, optionally `repeatability_um`.
struct ModelSpec {
  std::string machine;  // as written; may be empty when the session brings the machine
  std::vector<EffectSpec> effects;
  double repeatability = -1.0;  // m; negative: not stated
};

/// @throw InputError naming file, line and key for malformed YAML, unknown keys or effects without a type.
ModelSpec loadModelSpec(const std::filesystem::path& file);
ModelSpec parseModelSpec(const std::string& yaml, const std::string& source);
/// One effect as flow YAML: `{type: backlash, axis: x}`. @throw InputError.
EffectSpec parseEffectSpec(const std::string& yaml, const std::string& source);

}  // namespace mm
