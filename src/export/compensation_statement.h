#pragma once
#include <string>
#include <vector>

#include "calibration_file/calibration.h"

namespace mm {

/// One fact that a numerical compensation is documented by.
struct CompensationFact {
  std::string name, text;
};

/// What ISO/TR 16907 asks to be told of a numerical compensation of geometric errors: which errors are
/// compensated, by kind and symbol; kinematic chain; uni- or bidirectional; squareness with its sign; limits
/// of the compensated volume. How large the errors were before and after, who compensates adds.
/// @param compensated of the calibration's effects those that are. @throw InputError: an effect cannot be
/// made again.
std::vector<CompensationFact> compensationFacts(const Calibration& calibration,
                                                const std::vector<EffectSpec>& compensated);

}  // namespace mm
