#include "model/model_spec.h"

#include "base/error.h"
#include "base/read_file.h"
#include "base/units.h"
#include "base/yaml_mapping.h"
#include "effects/effect_yaml.h"

namespace mm {
namespace {

double repeatabilityOf(const YamlMapping& file) {
  const double value = file.number("repeatability_um", kMicrometre);
  if (!(value > 0.0))
    file.fail("repeatability_um",
              "is " + file.text("repeatability_um") + "; it must be above 0 (leave it out when unknown)");
  return value;
}

}  // namespace

ModelSpec parseModelSpec(const std::string& yaml, const std::string& source) {
  const YamlMapping file(YamlMapping::load(yaml, source), source, "the model",
                         {"machine", "effects", "repeatability_um"});
  ModelSpec spec;
  if (file.has("machine")) spec.machine = file.text("machine");
  if (!file.has("effects"))
    file.fail("effects", "is missing; write 'effects: []' for a machine without errors");
  if (!file.node("effects").IsNull())
    for (const YAML::Node& effect : file.list("effects"))
      spec.effects.push_back(effectSpecOf(effect, source));
  if (file.has("repeatability_um")) spec.repeatability = repeatabilityOf(file);
  return spec;
}

ModelSpec loadModelSpec(const std::filesystem::path& file) {
  return parseModelSpec(readWholeFile(file, "check the path of the model file"), file.string());
}

EffectSpec parseEffectSpec(const std::string& yaml, const std::string& source) {
  return effectSpecOf(YamlMapping::load(yaml, source), source);
}

}  // namespace mm
