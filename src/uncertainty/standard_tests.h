#pragma once
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// A test of a standard that the rows of a session are.
struct StandardTest {
  std::string test;     // "iso230-3"
  std::string inWords;  // "ISO 230-3, linear axis x: 180 readings at 3 positions over 5.0 h"
};

/// The tests that are recognised by the rows alone: ISO 230-3 (thermalTests), ISO 230-6
/// (diagonalTests), ISO 230-7 (rotationTests), ISO 10360-2 (lengthTests).
std::vector<StandardTest> standardTests(const Session& session);

}  // namespace mm
