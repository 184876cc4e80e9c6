#include "uncertainty/standard_tests.h"

#include "uncertainty/diagonal_tests.h"
#include "uncertainty/length_tests.h"
#include "uncertainty/rotation_tests.h"
#include "uncertainty/thermal_tests.h"

namespace mm {

std::vector<StandardTest> standardTests(const Session& session) {
  std::vector<StandardTest> tests;
  const auto add = [&](const char* standard, const auto& found) {
    for (const auto& test : found) tests.push_back({standard, inWords(test)});
  };
  add("iso230-3", thermalTests(session));
  add("iso230-6", diagonalTests(session));
  add("iso230-7", rotationTests(session));
  add("iso10360-2", lengthTests(session));
  return tests;
}

}  // namespace mm
