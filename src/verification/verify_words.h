#pragma once
#include <string>

#include "verification/verify.h"

namespace mm {

/// Standard deviations by which two figures differ.
constexpr double kFiguresDiffer = 3.3;

/// The word for what was found. @param improvement of the figure, in its standard deviations.
VerifyVerdict verdictOf(const Verification& verification, double improvement);
/// Why what is active stays active although the verdict is not `helped`; empty: no reason.
std::string whyKept(const Verification& verification);

/// What was loaded how, in words: "x and y have each other's table"; empty: everything is corrected.
/// @param axes names. @param loaded see VerifyOptions.
std::string inWords(const LoadedHow& hypothesis, const std::vector<std::string>& axes, bool loaded);
/// How much remains: the state of a correction (0 corrected, 1 not, 2 wrong sign, -1 twice) that lies within
/// 3.3 standard deviations, if half the way to its neighbours does not; else what remains, or that these
/// points cannot tell.
std::string inWords(const RemainingShare& share);
std::string inWords(const RemainingOfEffect& effect);  ///< the same, with what no table carries
/// The whole answer, with both figures and what to do. It begins with what the verdict says.
std::string sentenceOf(const Verification& verification);

}  // namespace mm
