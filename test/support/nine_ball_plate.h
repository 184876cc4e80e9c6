#pragma once
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "long_tests.h"
#include "session/plan.h"

namespace mm::test {

/// config/plans/nine_ball_plate.yaml with so many contacts of each ball, instead of 75.
inline Plan nineBallPlate(const Machine& machine, int points) {
  const std::string file = "config/plans/nine_ball_plate.yaml", whole = "points: 75";
  std::ifstream in(file);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const std::size_t at = text.find(whole);
  if (at == std::string::npos) throw std::logic_error(file + " has no '" + whole + "'");
  text.replace(at, whole.size(), "points: " + std::to_string(points));
  return Plan::parse(text, file, ".", machine);
}

/// @param whole also every day; else only in a thorough run.
inline Plan everydayPlate(const Machine& machine, bool whole = false) {
  return nineBallPlate(machine, whole || mm_test::thoroughTests() ? 75 : 30);
}

}  // namespace mm::test
