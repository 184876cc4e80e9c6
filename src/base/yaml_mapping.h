#pragma once
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace mm {

/// A mapping of a YAML file of which no key may be unknown; messages name file, line and key. Include only in
/// .cpp files. All members throw InputError.
class YamlMapping {
 public:
  /// @param what a few words for messages ("the plan"). Refuses keys that are not in `known`, or given twice.
  YamlMapping(const YAML::Node& node, std::string source, std::string what,
              const std::vector<std::string>& known);
  /// Of a file that a program wrote: the keys that are asked for are the known ones, and finish() refuses the
  /// others. @param remedy ends every message: what to do with a file that is not as it was written.
  static YamlMapping written(const YAML::Node& node, std::string source, std::string what,
                             std::string remedy);
  /// The root of a text. Refuses what is not YAML.
  static YAML::Node load(const std::string& yaml, const std::string& source);

  bool has(const std::string& key) const { return static_cast<bool>(node_[key]); }  ///< whether it is given
  YAML::Node node(const std::string& key) const;                                    ///< refuses a missing key
  YamlMapping map(const std::string& key) const;                                    ///< a mapping in this one
  std::vector<YAML::Node> list(const std::string& key) const;  ///< items; refuses what is none
  /// A mapping that is item `index` of the list `key`; known keys and remedy as of this one.
  YamlMapping item(const YAML::Node& node, const std::string& key, std::size_t index) const;
  /// Keys in the order of the file.
  std::vector<std::string> keys() const;
  std::string text(const std::string& key) const;
  std::vector<std::string> texts(const std::string& key) const;  ///< a word or a list of words
  /// A number times `factor`; within [lower, upper] as written.
  double number(const std::string& key, double factor, double lower, double upper) const;
  double number(const std::string& key, double factor) const;
  int count(const std::string& key, int lower) const;
  bool flag(const std::string& key) const;               ///< true or false
  std::string storedText(const std::string& key) const;  ///< any text, also none
  /// A number as numberText writes it, `.nan` and `.inf` too; the same bits.
  double stored(const std::string& key) const;
  std::vector<double> storedList(const std::string& key) const;  ///< a list of these, which may be empty
  std::vector<double> storedList(const YAML::Node& list, const std::string& key) const;
  std::vector<double> numbers(const std::string& key,
                              double factor) const;  ///< a number or a list of numbers
  Eigen::Vector3d vector(const std::string& key, double factor) const;
  int line() const { return lineOf(node_); }
  int line(const std::string& key) const { return lineOf(node(key)); }
  const std::string& source() const { return source_; }
  [[noreturn]] void fail(const std::string& key,
                         const std::string& message) const;  ///< key empty: the mapping itself
  [[noreturn]] void refuse(const YAML::Node& node, const std::string& message) const;  ///< a node in it
  /// Refuses the first key that was neither known nor asked for.
  void finish() const;

 private:
  static int lineOf(const YAML::Node& node) { return node.Mark().line < 0 ? 1 : node.Mark().line + 1; }
  struct Unchecked {};
  YamlMapping(Unchecked, const YAML::Node& node, std::string source, std::string what, std::string remedy);
  double convert(const YAML::Node& value, const std::string& key) const;
  YAML::Node node_;
  std::string source_, what_, remedy_;
  mutable std::vector<std::string> asked_;  // for finish()
};

}  // namespace mm
