#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/search.h"

namespace mm {

/// What of an explanation is drift, direction by direction, and which causes that change with time it may be.
struct DriftReport {
  std::vector<DriftResult> drift;
  /// The same explanation with this drift alone: what there is too little of to be spoken of is noise.
  Explanation spokenOf;
};
DriftReport driftOf(const Search& search, const Explanation& found);

}  // namespace mm
