#include "calibration_file/yaml_keys.h"

#include <algorithm>

#include "base/error.h"
#include "calibration_file/number_text.h"

namespace mm {

YamlKeys::YamlKeys(const YAML::Node& node, std::string source, std::string where)
    : node_(node), source_(std::move(source)), where_(std::move(where)) {
  if (!node_.IsMap()) refuse(node_, "must be a map of keys");
  std::vector<std::string> seen;
  for (const auto& pair : node_) {
    const std::string& key = pair.first.Scalar();
    if (std::find(seen.begin(), seen.end(), key) != seen.end())
      refuse(pair.first, "key '" + key + "' is given twice");
    seen.push_back(key);
  }
}

void YamlKeys::refuse(const YAML::Node& node, const std::string& what) const {
  const YAML::Mark mark = node.Mark();
  const std::string line = mark.is_null() ? "" : ":" + std::to_string(mark.line + 1);
  throw InputError(source_ + line + ": " + where_ + ": " + what +
                   "; calibrate again or take an undamaged copy");
}

YAML::Node YamlKeys::take(const std::string& key) {
  const YAML::Node value = static_cast<const YAML::Node&>(node_)[key];
  if (!value) refuse(node_, "key '" + key + "' is missing");
  taken_.push_back(key);
  return value;
}

std::string YamlKeys::text(const std::string& key) {
  const YAML::Node value = take(key);
  if (!value.IsScalar()) refuse(value, "'" + key + "' must be text");
  return value.Scalar();
}

double YamlKeys::number(const std::string& key) {
  const YAML::Node value = take(key);
  double read = 0.0;
  if (!value.IsScalar() || !parseNumber(value.Scalar(), read))
    refuse(value, "'" + key + "' must be a number");
  return read;
}

bool YamlKeys::flag(const std::string& key) {
  const std::string read = text(key);
  if (read != "true" && read != "false") refuse(node_, "'" + key + "' must be true or false");
  return read == "true";
}

std::vector<YAML::Node> YamlKeys::list(const std::string& key) {
  const YAML::Node value = take(key);
  if (!value.IsSequence()) refuse(value, "'" + key + "' must be a list");
  return {value.begin(), value.end()};
}

std::vector<double> YamlKeys::numbersOf(const YAML::Node& list, const std::string& key) const {
  if (!list.IsSequence()) refuse(list, "'" + key + "' must be a list of numbers");
  std::vector<double> values;
  for (const YAML::Node& item : list) {
    double value = 0.0;
    if (!item.IsScalar() || !parseNumber(item.Scalar(), value))
      refuse(item, "'" + key + "' must hold numbers only");
    values.push_back(value);
  }
  return values;
}

std::vector<double> YamlKeys::numbers(const std::string& key) { return numbersOf(take(key), key); }

YamlKeys YamlKeys::map(const std::string& key) { return {take(key), source_, key}; }

YamlKeys YamlKeys::item(const YAML::Node& node, const std::string& key, std::size_t index) const {
  return {node, source_, key + "[" + std::to_string(index) + "]"};
}

void YamlKeys::finish() const {
  for (const auto& pair : node_) {
    const std::string& key = pair.first.Scalar();
    if (std::find(taken_.begin(), taken_.end(), key) == taken_.end())
      refuse(pair.first, "unknown key '" + key + "'");
  }
}

}  // namespace mm
