#include "effects/effect_words.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <vector>

#include "base/text.h"
#include "effects/words_yaml.h"

namespace mm {
namespace {

/// words.yaml, which is compiled in.
const YAML::Node& words() {
  static const YAML::Node all = YAML::Load(kWordsYaml);
  return all;
}

/// The phrase with its keys put in; empty where one of them is not given, or {key=value} is not its value.
/// @param used the keys. @param more further words.
std::string filled(const std::string& phrase, const EffectSpec& effect, std::set<std::string>& used,
                   const std::map<std::string, std::string>& more = {}) {
  std::string text;
  used.clear();
  for (std::size_t at = 0; at < phrase.size();) {
    const std::size_t open = phrase.find('{', at);
    if (open == std::string::npos) return text + phrase.substr(at);
    const std::size_t close = phrase.find('}', open);
    const std::string inside = phrase.substr(open + 1, close - open - 1);
    const std::string key = inside.substr(0, inside.find('='));
    const EffectSpec::Value* value = effect.find(key);
    const auto word = more.find(key);
    if (word == more.end() && (value == nullptr || value->items.empty())) return {};
    const std::string of = word == more.end() ? enumerated(value->items) : word->second;
    const bool wanted = key != inside;
    if (wanted && inside != key + "=" + of) return {};
    text += phrase.substr(at, open - at) + (wanted ? "" : of);
    used.insert(key);
    at = close + 1;
  }
  return text;
}

/// ", degree 3"; ", period 2 mm"; ", with lag"; nothing for what is false.
std::string keyInWords(const std::string& key, const EffectSpec::Value& value) {
  const std::string text = enumerated(value.items);
  if (text == "false" || text.empty()) return {};
  if (text == "true") return ", with " + spaced(key);
  if (key == "from_session") return ", from session " + text + " on";
  for (const std::string unit : {"mm", "deg", "um", "s"}) {
    const std::string ending = "_" + unit;
    if (key.size() <= ending.size() || key.compare(key.size() - ending.size(), ending.size(), ending) != 0)
      continue;
    const bool number = text.find_first_not_of("0123456789.eE+-") == std::string::npos;
    return ", " + spaced(key.substr(0, key.size() - ending.size())) + " " + text + (number ? " " + unit : "");
  }
  return ", " + spaced(key) + " " + text;
}

}  // namespace

std::string spaced(std::string text) {
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string inWords(const EffectSpec& effect) {
  std::string text;
  std::set<std::string> used;
  std::vector<std::string> phrases;
  const YAML::Node ofType = words()[effect.type];  // a plugin's is not there
  if (ofType && ofType["called"])
    phrases = ofType["called"].IsSequence() ? ofType["called"].as<std::vector<std::string>>()
                                            : std::vector<std::string>{ofType["called"].as<std::string>()};
  for (const std::string& phrase : phrases)
    if (text.empty()) text = filled(phrase, effect, used);
  if (text.empty()) {
    used.clear();
    text = spaced(effect.type);
  }
  for (const auto& [key, value] : effect.keys)
    if (used.count(key) == 0) text += keyInWords(key, value);
  return text;
}

std::string listInWords(const std::vector<EffectSpec>& effects, std::size_t shown) {
  const std::size_t count = effects.size() > shown + 1 ? shown : effects.size();
  std::string text;
  for (std::size_t i = 0; i < count; ++i)
    text += (i == 0 ? "" : i + 1 == effects.size() ? " and " : ", ") + inWords(effects[i]);
  if (count < effects.size()) text += " and " + std::to_string(effects.size() - count) + " more";
  return text;
}

std::vector<std::string> typesInWords() {
  std::vector<std::string> types;
  for (const auto& entry : words()) types.push_back(entry.first.as<std::string>());
  return types;
}

std::string meaningOf(const EffectSpec& effect, const std::string& parameter) {
  const YAML::Node ofType = words()[effect.type];
  if (!ofType || !ofType["parameters"]) return {};
  std::set<std::string> used;
  for (const auto& entry : ofType["parameters"]) {
    const auto name = entry.first.as<std::string>();
    const bool any = name.back() == '*';
    if (any ? parameter.compare(0, name.size() - 1, name, 0, name.size() - 1) == 0 : parameter == name)
      return filled(entry.second.as<std::string>(), effect, used);
  }
  return {};
}

std::string wordsOf(const EffectSpec& effect, const std::string& what, const std::string& variant,
                    const std::map<std::string, std::string>& more) {
  const YAML::Node own = words()[effect.type + " " + variant], ofType = words()[effect.type];
  const YAML::Node text = own && own[what] ? own[what] : ofType[what];
  std::set<std::string> used;
  const std::string whole = filled(text.as<std::string>(), effect, used, more);
  if (whole.empty())
    throw std::logic_error("words.yaml: " + what + " of " + effect.type + " names a key that " +
                           effect.yaml() + " has not");
  return whole;
}

}  // namespace mm
