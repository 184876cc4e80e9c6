#pragma once
#include <memory>
#include <string>
#include <vector>

namespace mm {

/// A regular expression in ECMAScript's grammar. std::regex is compiled in one source: it takes seconds.
class Pattern {
 public:
  explicit Pattern(const char* expression);  ///< @throw std::regex_error: it is none
  /// The whole of a text that the pattern matches from end to end, then its groups, empty where one has no
  /// part; otherwise nothing.
  std::vector<std::string> parts(const std::string& text) const;
  /// Whether a text matches from end to end.
  bool matches(const std::string& text) const { return !parts(text).empty(); }
  /// The text without the parts that match.
  std::string removedFrom(const std::string& text) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace mm
