#pragma once
#include <cstdlib>

namespace mm_test {

/// True where the environment asks for the tests at their full length: MM_LONG_TESTS=1.
inline bool longTests() {
  const char* asked = std::getenv("MM_LONG_TESTS");
  return asked != nullptr && *asked != '\0' && *asked != '0';
}

}  // namespace mm_test
