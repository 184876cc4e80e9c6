#pragma once
#include <string>
#include <vector>

#include "uncertainty/positioning_figures.h"
#include "uncertainty/residual_of.h"

namespace mm {

/// A diagonal of the machine's volume or of one of its faces, measured to and fro by ISO 230-6: the
/// displacement along it, actual minus indicated, from the first reading. Its figures are those of a
/// positioning test: E is the bidirectional systematic deviation of the diagonal displacement.
struct DiagonalTest {
  std::string name;                // "+x+y-z": where its axes go as the instrument sees the tip go away
  std::string setup;               // of the instrument; empty: none
  PositioningTest measured, left;  // as the machine is; what a model leaves
  std::vector<PositioningRun> runs, leftRuns;  // mm along the diagonal, um
};

/// Lengths from one point along the line on which two or more linear joints move together: at least five
/// targets, each reached from both sides. Direction of travel as recorded or assumed. Every run counts.
/// @param left may be empty: then nothing is left.
std::vector<DiagonalTest> diagonalTests(const Session& session, const ResidualOf& left = {});

/// "ISO 230-6, diagonal +x+y-z: 50 readings at 5 positions".
std::string inWords(const DiagonalTest& test);

}  // namespace mm
