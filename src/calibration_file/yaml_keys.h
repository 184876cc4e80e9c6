#pragma once
#include <yaml-cpp/yaml.h>

#include <string>
#include <vector>

namespace mm {

/// A map of a YAML file of which every key must be taken: the rest is refused by name, with file and line.
class YamlKeys {
 public:
  /// @param where name of the map for messages. @throw InputError when it is not a map or a key comes twice.
  YamlKeys(const YAML::Node& node, std::string source, std::string where);

  /// @throw InputError when the key is missing.
  YAML::Node take(const std::string& key);
  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }
  std::string text(const std::string& key);
  double number(const std::string& key);
  bool flag(const std::string& key);
  std::vector<double> numbers(const std::string& key);
  std::vector<double> numbersOf(const YAML::Node& list, const std::string& key) const;
  /// The items of a list. @throw InputError when it is none.
  std::vector<YAML::Node> list(const std::string& key);
  YamlKeys map(const std::string& key);
  YamlKeys item(const YAML::Node& node, const std::string& key, std::size_t index) const;

  /// @throw InputError naming the first key that was not taken.
  void finish() const;
  [[noreturn]] void refuse(const YAML::Node& node, const std::string& what) const;

 private:
  YAML::Node node_;
  std::string source_, where_;
  std::vector<std::string> taken_;
};

}  // namespace mm
