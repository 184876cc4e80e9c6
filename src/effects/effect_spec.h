#pragma once
#include <string>
#include <utility>
#include <vector>

namespace mm {

/// What a user writes to name an effect: `{type: backlash, axis: x}`. Keys keep their order; values are
/// scalars or lists of scalars, kept as text.
class EffectSpec {
 public:
  struct Value {
    std::vector<std::string> items;
    bool list = false;
    /// The same items; numbers by their value: 1 is 1.0.
    bool operator==(const Value& o) const;
  };

  EffectSpec() = default;
  explicit EffectSpec(std::string type) : type(std::move(type)) {}  ///< without keys

  std::string type;
  std::vector<std::pair<std::string, Value>> keys;

  EffectSpec& set(const std::string& key, const std::string& value);  ///< adds or replaces
  EffectSpec& set(const std::string& key, double value);  // shortest text that reads back the same
  EffectSpec& setList(const std::string& key, std::vector<std::string> items);  ///< adds or replaces
  const Value* find(const std::string& key) const;                              ///< null when absent
  std::string text(const std::string& key) const;                               // empty when absent

  /// The same type and the same values, in whatever order they stand.
  bool operator==(const EffectSpec& o) const;

  /// One line of YAML: `{type: backlash, axis: x}`.
  std::string yaml() const;
};

}  // namespace mm
