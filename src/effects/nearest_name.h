#pragma once
#include <string>
#include <vector>

#include "machine/nearest_name.h"

namespace mm {

/// "a, b, c", or "none".
std::string listOf(const std::vector<std::string>& names);

}  // namespace mm
