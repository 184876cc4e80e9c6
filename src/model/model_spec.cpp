#include "model/model_spec.h"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "base/error.h"
#include "base/units.h"
#include "effects/registry.h"

namespace mm {
namespace {

std::string place(const std::string& source, const YAML::Mark& mark) {
  return mark.is_null() ? source : source + ":" + std::to_string(mark.line + 1);
}

[[noreturn]] void refuse(const std::string& source, const YAML::Node& node, const std::string& what) {
  throw InputError(place(source, node.Mark()) + ": " + what);
}

YAML::Node load(const std::string& yaml, const std::string& source) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw InputError(place(source, e.mark) + ": not valid YAML: " + e.msg);
  }
}

EffectSpec effectOf(const YAML::Node& node, const std::string& source) {
  if (!node.IsMap()) refuse(source, node, "an effect is a map such as {type: backlash, axis: x}");
  EffectSpec spec;
  for (const auto& pair : node) {
    const std::string key = pair.first.Scalar();
    const YAML::Node& value = pair.second;
    if (key == "type") {
      if (!value.IsScalar() || !spec.type.empty())
        refuse(source, pair.first, "'type' of an effect is one name, given once");
      spec.type = presentType(value.Scalar());
      continue;
    }
    if (spec.find(key) != nullptr)
      refuse(source, pair.first, "key '" + key + "' is given twice in one effect");
    EffectSpec::Value read;
    if (value.IsScalar()) {
      read.items.push_back(value.Scalar());
    } else if (value.IsSequence()) {
      read.list = true;
      for (const YAML::Node& item : value) {
        if (!item.IsScalar()) refuse(source, item, "key '" + key + "': a list may only hold plain values");
        read.items.push_back(item.Scalar());
      }
    } else {
      refuse(source, pair.first, "key '" + key + "' needs a value or a list of values");
    }
    spec.keys.emplace_back(key, std::move(read));
  }
  if (spec.type.empty()) refuse(source, node, "effect without 'type', e.g. {type: backlash, axis: x}");
  return spec;
}

double repeatabilityOf(const YAML::Node& node, const std::string& source) {
  double micrometres = 0.0;
  try {
    micrometres = node.as<double>();
  } catch (const YAML::Exception&) {
    refuse(source, node, "'repeatability_um' must be a number, in micrometres");
  }
  if (!(micrometres > 0.0) || !std::isfinite(micrometres))
    refuse(source, node,
           "'repeatability_um' is " + node.Scalar() + "; it must be above 0 (leave it out when unknown)");
  return micrometres * kMicrometre;
}

}  // namespace

ModelSpec parseModelSpec(const std::string& yaml, const std::string& source) {
  const YAML::Node root = load(yaml, source);
  if (!root.IsMap()) throw InputError(source + ":1: a model file has the keys 'machine' and 'effects'");
  ModelSpec spec;
  bool effects = false, machine = false;
  for (const auto& pair : root) {
    const std::string key = pair.first.Scalar();
    const YAML::Node& value = pair.second;
    if (key == "machine") {
      if (!value.IsScalar() || value.Scalar().empty() || machine)
        refuse(source, pair.first, "'machine' is three_axis, five_axis or the path of a URDF, given once");
      spec.machine = value.Scalar();
      machine = true;
    } else if (key == "effects") {
      if (effects) refuse(source, pair.first, "'effects' is given twice");
      if (!value.IsNull() && !value.IsSequence())
        refuse(source, pair.first, "'effects' is a list of {type: ...}");
      for (const YAML::Node& effect : value) spec.effects.push_back(effectOf(effect, source));
      effects = true;
    } else if (key == "repeatability_um") {
      spec.repeatability = repeatabilityOf(value, source);
    } else {
      refuse(source, pair.first,
             "unknown key '" + key + "'; a model file knows machine, effects, repeatability_um");
    }
  }
  if (!effects)
    throw InputError(source + ":1: 'effects' is missing; write 'effects: []' for a machine without errors");
  return spec;
}

ModelSpec loadModelSpec(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file.string() + ": cannot be opened; check the path of the model file");
  std::ostringstream text;
  text << in.rdbuf();
  return parseModelSpec(text.str(), file.string());
}

EffectSpec parseEffectSpec(const std::string& yaml, const std::string& source) {
  return effectOf(load(yaml, source), source);
}

}  // namespace mm
