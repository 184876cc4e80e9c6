#pragma once
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace mm {

/// A mapping of a YAML file with a known set of keys; messages name file, line and key. Include only in .cpp
/// files. All members throw InputError.
class YamlMapping {
 public:
  /// @param what a few words for messages ("the plan"). Refuses keys that are not in `known`, or given twice.
  YamlMapping(const YAML::Node& node, std::string source, std::string what,
              const std::vector<std::string>& known);
  /// The root of a text. Refuses what is not YAML.
  static YAML::Node load(const std::string& yaml, const std::string& source);

  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }  ///< whether it is given
  YAML::Node node(const std::string& key) const;                                    ///< refuses a missing key
  /// Keys in the order of the file.
  std::vector<std::string> keys() const;
  std::string text(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;  ///< a word or a list of words
  /// A number times `factor`; within [lower, upper] as written.
  double number(const std::string& key, double factor, double lower, double upper) const;
  double number(const std::string& key, double factor) const;
  int count(const std::string& key, int lower) const;
  std::vector<double> numbers(const std::string& key,
                              double factor) const;  ///< a number or a list of numbers
  Eigen::Vector3d vector(const std::string& key, double factor) const;
  int line() const { return lineOf(node_); }
  int line(const std::string& key) const { return lineOf(node(key)); }
  const std::string& source() const { return source_; }
  [[noreturn]] void fail(const std::string& key,
                         const std::string& message) const;  ///< key empty: the mapping itself

 private:
  static int lineOf(const YAML::Node& node) { return node.Mark().line < 0 ? 1 : node.Mark().line + 1; }
  double convert(const YAML::Node& value, const std::string& key) const;
  YAML::Node node_;
  std::string source_, what_;
};

}  // namespace mm
