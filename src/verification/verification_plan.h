#pragma once
#include <cstddef>
#include <vector>

#include "calibration_file/calibration.h"
#include "session/plan.h"

namespace mm {

/// How large a verification is.
struct VerificationSize {
  int places = 10;  // balls; postures at one ball; positions that an instrument reads
  int touches = 6;  // of each place
};

/// The moves of a plan that best show, together, whether a calibration's correction is applied, on which axis
/// and with which sign, and what has changed since: greedily those that lower most the determinant of the
/// covariance of all this (D-optimal; Fedorov 1972), the session's own unknowns among it.
/// @param plan whose moves are known to be feasible. @return indices of plan.moves, ascending.
/// @throw InputError: of another machine; the calibration corrects nothing of it.
std::vector<std::size_t> verificationMoves(const Plan& plan, const Calibration& calibration,
                                           const VerificationSize& size);

}  // namespace mm
