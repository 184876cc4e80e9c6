#include "effects/effect_spec.h"

#include <yaml-cpp/emitter.h>
#include <yaml-cpp/emittermanip.h>
#include <yaml-cpp/stlemitter.h>

#include <algorithm>
#include <charconv>

#include "base/number_text.h"

namespace mm {
namespace {

EffectSpec::Value& slot(EffectSpec& spec, const std::string& key) {
  for (auto& entry : spec.keys)
    if (entry.first == key) return entry.second;
  spec.keys.push_back({key, {}});
  return spec.keys.back().second;
}

bool sameItem(const std::string& a, const std::string& b) {
  double x = 0.0, y = 0.0;
  return a == b || (parseNumber(a, x) && parseNumber(b, y) && x == y);
}

}  // namespace

bool EffectSpec::Value::operator==(const Value& o) const {
  return list == o.list && std::equal(items.begin(), items.end(), o.items.begin(), o.items.end(), sameItem);
}

EffectSpec& EffectSpec::set(const std::string& key, const std::string& value) {
  slot(*this, key) = {{value}, false};
  return *this;
}

EffectSpec& EffectSpec::set(const std::string& key, double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof(text), value).ptr;
  return set(key, std::string(text, end));
}

EffectSpec& EffectSpec::setList(const std::string& key, std::vector<std::string> items) {
  slot(*this, key) = {std::move(items), true};
  return *this;
}

const EffectSpec::Value* EffectSpec::find(const std::string& key) const {
  for (const auto& entry : keys)
    if (entry.first == key) return &entry.second;
  return nullptr;
}

std::string EffectSpec::text(const std::string& key) const {
  const Value* value = find(key);
  return value == nullptr || value->items.empty() ? std::string() : value->items.front();
}

bool EffectSpec::operator==(const EffectSpec& o) const {
  return type == o.type && keys.size() == o.keys.size() &&
         std::all_of(keys.begin(), keys.end(), [&](const auto& key) {
           const Value* other = o.find(key.first);
           return other != nullptr && *other == key.second;
         });
}

std::string EffectSpec::yaml() const {
  YAML::Emitter out;
  out << YAML::Flow << YAML::BeginMap << YAML::Key << "type" << YAML::Value << type;
  for (const auto& [key, value] : keys) {
    out << YAML::Key << key << YAML::Value;
    if (value.list)
      out << YAML::Flow << value.items;
    else
      out << (value.items.empty() ? std::string() : value.items.front());
  }
  out << YAML::EndMap;
  return out.c_str();
}

}  // namespace mm
