#pragma once
#include "diagnosis/candidates.h"
#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// Everything that belongs to one round of the search.
struct Round {
  /// @param extra candidates beside those of the registry.
  explicit Round(const CalibrationResult& fitted, const std::vector<EffectSpec>& extra = {})
      : space(fitted), set(makeCandidates(space, extra)), search(space, set) {}
  ResidualSpace space;
  CandidateSet set;
  SubsetSearch search;
};

}  // namespace mm
