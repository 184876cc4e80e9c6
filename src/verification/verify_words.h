#pragma once
#include <string>

#include "verification/verify.h"

namespace mm {

/// What was loaded how, in words: "x and y have each other's table"; empty: everything is corrected.
/// @param axes names. @param loaded see VerifyOptions.
std::string inWords(const LoadedHow& hypothesis, const std::vector<std::string>& axes, bool loaded);
/// How much remains, in a word or two; "not told by these points" where its uncertainty is too large.
std::string inWords(const RemainingShare& share);
/// The whole answer, with both figures and what to do.
std::string sentenceOf(const Verification& verification);

}  // namespace mm
