#pragma once
#include <vector>

#include "diagnosis/posterior_search.h"

namespace mm {

/// What of an explanation is drift, direction by direction, and which causes that change with time it may be.
struct DriftReport {
  std::vector<DriftResult> drift;
  /// The same explanation with this drift alone: what there is too little of to be spoken of is noise.
  Explanation spokenOf;
};
/// @param answer of which the causes have their probability.
DriftReport driftOf(const Search& search, const Explanation& found, const PosteriorAnswer& answer);

}  // namespace mm
