#pragma once
#include <cstdlib>

namespace mm_test {

inline bool asked(const char* variable) {
  const char* value = std::getenv(variable);
  return value != nullptr && *value != '\0' && *value != '0';
}

/// True where the environment asks for the tests at their full length, hours: MM_LONG_TESTS=1.
inline bool longTests() { return asked("MM_LONG_TESTS"); }

/// True where it asks for more than an everyday run has time for: MM_THOROUGH_TESTS=1, as continuous
/// integration does (scripts/test --thorough).
inline bool thoroughTests() { return asked("MM_THOROUGH_TESTS") || longTests(); }

}  // namespace mm_test

/// Ends a test that an everyday run has no time for, with its reason.
#define MM_THOROUGH_ONLY(why) \
  if (!mm_test::thoroughTests()) GTEST_SKIP() << "scripts/test --thorough: " why
