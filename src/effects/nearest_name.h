#pragma once
#include <string>
#include <vector>

namespace mm {

/// " (did you mean 'x'?)" when one of the known names is close to what was written, else empty.
std::string didYouMean(const std::string& written, const std::vector<std::string>& known);

/// "a, b, c", or "none".
std::string listOf(const std::vector<std::string>& names);

}  // namespace mm
