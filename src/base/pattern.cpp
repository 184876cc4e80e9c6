#include "base/pattern.h"

#include <regex>

namespace mm {

struct Pattern::Compiled {
  std::regex regex;
};

Pattern::Pattern(const char* expression)
    : compiled_(std::make_shared<const Compiled>(Compiled{std::regex(expression)})) {}

std::vector<std::string> Pattern::parts(const std::string& text) const {
  std::smatch match;
  if (!std::regex_match(text, match, compiled_->regex)) return {};
  return {match.begin(), match.end()};
}

std::string Pattern::removedFrom(const std::string& text) const {
  return std::regex_replace(text, compiled_->regex, "");
}

}  // namespace mm
