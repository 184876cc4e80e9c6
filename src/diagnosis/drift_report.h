#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/search.h"

namespace mm {

/// What of the explanation is drift, direction by direction, and which causes that change with time it may
/// be.
std::vector<DriftResult> driftOf(const Search& search, const Explanation& found);

}  // namespace mm
