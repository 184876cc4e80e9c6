#pragma once
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"

namespace mm {

/// The verdict as one sentence for people. @param left what each variable explains of what is left at the
/// end.
std::string sentenceOf(const Diagnosis& diagnosis, const std::vector<WhereItFails>& left);

/// A number with three significant digits.
std::string shortNumber(double value);

}  // namespace mm
