#include "effects/effect_yaml.h"

#include "base/yaml_mapping.h"
#include "effects/registry.h"

namespace mm {

EffectSpec effectSpecOf(const YAML::Node& node, const std::string& source) {
  const YamlMapping map = YamlMapping::written(
      node, source, "an effect", "; write it as {type: backlash, axis: x}, mm effects lists them");
  EffectSpec spec(presentType(map.text("type")));
  for (const std::string& key : map.keys()) {
    if (key == "type") continue;
    const YAML::Node value = map.node(key);
    EffectSpec::Value read;
    read.list = value.IsSequence();
    if (value.IsScalar()) {
      read.items.push_back(value.Scalar());
    } else if (read.list) {
      for (const YAML::Node& item : value) {
        if (!item.IsScalar()) map.fail(key, "is a list that may only hold plain values");
        read.items.push_back(item.Scalar());
      }
    } else {
      map.fail(key, "needs a value or a list of values");
    }
    spec.keys.emplace_back(key, std::move(read));
  }
  return spec;
}

}  // namespace mm
