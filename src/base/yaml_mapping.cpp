#include "base/yaml_mapping.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/number_text.h"

namespace mm {
namespace {

std::string plain(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace

YamlMapping::YamlMapping(const YAML::Node& node, std::string source, std::string what,
                         const std::vector<std::string>& known)
    : YamlMapping(Unchecked(), node, std::move(source), std::move(what), {}) {
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(known.begin(), known.end(), key) == known.end())
      refuse(entry.first,
             "unknown key '" + key + "'" + didYouMean(key, known) + " (known are " + listOf(known) + ")");
  }
}

YamlMapping::YamlMapping(Unchecked, const YAML::Node& node, std::string source, std::string what,
                         std::string remedy)
    : node_(node), source_(std::move(source)), what_(std::move(what)), remedy_(std::move(remedy)) {
  if (!node_.IsMap()) fail("", "must be a mapping of keys to values");
  std::set<std::string> seen;
  for (const auto& entry : node_)
    if (entry.first.IsScalar() && !seen.insert(entry.first.Scalar()).second)
      refuse(entry.first, "key '" + entry.first.Scalar() + "' is given twice");
}

YamlMapping YamlMapping::written(const YAML::Node& node, std::string source, std::string what,
                                 std::string remedy) {
  return {Unchecked(), node, std::move(source), std::move(what), std::move(remedy)};
}

void YamlMapping::refuse(const YAML::Node& node, const std::string& message) const {
  throw InputError(source_ + ":" + std::to_string(lineOf(node)) + ": " + what_ + ": " + message + remedy_);
}

void YamlMapping::finish() const {
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (std::find(asked_.begin(), asked_.end(), key) == asked_.end())
      refuse(entry.first, "unknown key '" + key + "'");
  }
}

YAML::Node YamlMapping::load(const std::string& yaml, const std::string& source) {
  try {
    return YAML::Load(yaml);
  } catch (const YAML::Exception& e) {
    throw InputError(
        source + ":" + std::to_string(e.mark.line + 1) + ": not YAML: " + e.msg +
        "; look there and on the line before for a missing bracket, comma or quote, or blanks that "
        "do not line up");
  }
}

void YamlMapping::fail(const std::string& key, const std::string& message) const {
  const int line = key.empty() || !has(key) ? lineOf(node_) : lineOf(node_[key]);
  throw InputError(source_ + ":" + std::to_string(line) + ": " + what_ +
                   (key.empty() ? "" : ": '" + key + "'") + " " + message + remedy_);
}

YAML::Node YamlMapping::node(const std::string& key) const {
  if (!has(key)) fail(key, "is missing");
  asked_.push_back(key);
  return node_[key];
}

YamlMapping YamlMapping::map(const std::string& key) const {
  return {Unchecked(), node(key), source_, key, remedy_};
}

std::vector<YAML::Node> YamlMapping::list(const std::string& key) const {
  const YAML::Node value = node(key);
  if (!value.IsSequence()) fail(key, "must be a list");
  return {value.begin(), value.end()};
}

YamlMapping YamlMapping::item(const YAML::Node& node, const std::string& key, std::size_t index) const {
  return {Unchecked(), node, source_, key + "[" + std::to_string(index) + "]", remedy_};
}

std::vector<std::string> YamlMapping::keys() const {
  std::vector<std::string> keys;
  for (const auto& entry : node_) keys.push_back(entry.first.Scalar());
  return keys;
}

std::string YamlMapping::text(const std::string& key) const {
  const YAML::Node value = node(key);
  if (!value.IsScalar() || value.Scalar().empty()) fail(key, "must be a word");
  return value.Scalar();
}

std::vector<std::string> YamlMapping::texts(const std::string& key) const {
  const YAML::Node value = node(key);
  if (value.IsScalar()) return {text(key)};
  std::vector<std::string> words;
  if (!value.IsSequence()) fail(key, "must be a word or a list of words");
  for (const YAML::Node& word : value) {
    if (!word.IsScalar()) fail(key, "must be a list of plain words");
    words.push_back(word.Scalar());
  }
  return words;
}

double YamlMapping::convert(const YAML::Node& value, const std::string& key) const {
  double number = 0.0;
  if (!value.IsScalar() || !YAML::convert<double>::decode(value, number) || !std::isfinite(number))
    fail(key,
         "must be a finite number" + (value.IsScalar() ? ", not '" + value.Scalar() + "'" : std::string()));
  return number;
}

double YamlMapping::number(const std::string& key, double factor, double lower, double upper) const {
  const double value = convert(node(key), key);
  if (value < lower || value > upper)
    fail(key, "is " + plain(value) + ", but must be from " + plain(lower) + " to " + plain(upper));
  return value * factor;
}

double YamlMapping::number(const std::string& key, double factor) const {
  return convert(node(key), key) * factor;
}

int YamlMapping::count(const std::string& key, int lower) const {
  const double value = convert(node(key), key);
  if (value < lower || value != std::floor(value) || value > 1e7)
    fail(key, "is " + plain(value) + ", but must be a whole number of at least " + std::to_string(lower));
  return static_cast<int>(value);
}

bool YamlMapping::flag(const std::string& key) const {
  const std::string read = text(key);
  if (read != "true" && read != "false") fail(key, "is '" + read + "', but must be true or false");
  return read == "true";
}

std::string YamlMapping::storedText(const std::string& key) const {
  const YAML::Node value = node(key);
  if (!value.IsScalar()) fail(key, "must be text");
  return value.Scalar();
}

double YamlMapping::stored(const std::string& key) const {
  const YAML::Node value = node(key);
  double read = 0.0;
  if (!value.IsScalar() || !parseNumber(value.Scalar(), read)) fail(key, "must be a number");
  return read;
}

std::vector<double> YamlMapping::storedList(const std::string& key) const {
  return storedList(node(key), key);
}

std::vector<double> YamlMapping::storedList(const YAML::Node& list, const std::string& key) const {
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

std::vector<double> YamlMapping::numbers(const std::string& key, double factor) const {
  const YAML::Node value = node(key);
  if (value.IsScalar()) return {number(key, factor)};
  if (!value.IsSequence() || value.size() == 0) fail(key, "must be a number or a list of numbers");
  std::vector<double> numbers;
  for (const YAML::Node& item : value) numbers.push_back(convert(item, key) * factor);
  return numbers;
}

Eigen::Vector3d YamlMapping::vector(const std::string& key, double factor) const {
  const std::vector<double> v = numbers(key, factor);
  if (v.size() != 3) fail(key, "must be three numbers, [x, y, z]");
  return {v[0], v[1], v[2]};
}

}  // namespace mm
