#pragma once
#include <string>

namespace mm {

/// printf into a string of at most 511 characters.
std::string format(const char* pattern, ...) __attribute__((format(printf, 1, 2)));

}  // namespace mm
