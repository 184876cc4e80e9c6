#pragma once
#include <string>
#include <vector>

namespace mm {

/// The `name` of each thing in a list.
template <typename List>
std::vector<std::string> allNames(const List& list) {
  std::vector<std::string> names;
  for (const auto& thing : list) names.push_back(thing.name);
  return names;
}

}  // namespace mm
