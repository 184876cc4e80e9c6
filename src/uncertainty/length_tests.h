#pragma once
#include <string>
#include <vector>

#include "uncertainty/residual_of.h"

namespace mm {

/// A length that was measured from its first face to its far one, each reached from its own side.
struct LengthError {
  double length = 0.0;         // mm, indicated
  double error = 0.0;          // um, indicated minus actual
  double left = kNotMeasured;  // um, what a model leaves
};

/// Lengths along lines of the machine's volume, in the manner of ISO 10360-2: E is the error of one length.
struct LengthLineTest {
  std::string name;                 // of the point that the instrument measured from
  std::string setup;                // of the instrument; empty: none
  std::vector<LengthError> errors;  // in the order measured
  double largest = kNotMeasured, largestLeft = kNotMeasured;  // um, the largest amounts
  int lengths = 0;                                            // that differ
};

/// One test a point and a zero: pairs of rows, near and far, with opposite directions of travel, of at least
/// five lengths. @param left may be empty: then nothing is left.
std::vector<LengthLineTest> lengthTests(const Session& session, const ResidualOf& left = {});

/// "ISO 10360-2, line +x+y: 15 errors of 5 lengths".
std::string inWords(const LengthLineTest& test);

}  // namespace mm
