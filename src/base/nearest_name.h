#pragma once
#include <string>
#include <vector>

namespace mm {

/// Number of single-character insertions, deletions, replacements or swaps of neighbours between two names.
int editDistance(const std::string& a, const std::string& b);

/// The known name that a misspelt one most likely meant; empty when none is near.
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// "a, b, c", or "none".
std::string listOf(const std::vector<std::string>& names);

/// `; did you mean 'x_mm'?` for the end of an error message, or empty.
std::string didYouMean(const std::string& name, const std::vector<std::string>& known);

}  // namespace mm
