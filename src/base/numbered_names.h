#pragma once
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace mm {

/// Names, numbered as they occur.
class NumberedNames {
 public:
  /// The number of a name, from 0; one that was not met before gets the next.
  int operator[](std::string_view name) {
    const auto [at, fresh] = index_.try_emplace(std::string(name), static_cast<int>(names_.size()));
    if (fresh) names_.emplace_back(name);
    return at->second;
  }
  const std::vector<std::string>& all() const { return names_; }  ///< by their numbers

 private:
  std::unordered_map<std::string, int> index_;
  std::vector<std::string> names_;
};

}  // namespace mm
