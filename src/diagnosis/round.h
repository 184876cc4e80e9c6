#pragma once
#include "diagnosis/candidates.h"
#include "diagnosis/residual_space.h"
#include "diagnosis/subset_search.h"

namespace mm {

/// Everything that belongs to one round of the search.
struct Round {
  explicit Round(const CalibrationResult& fitted)
      : space(fitted), set(makeCandidates(space)), search(space, set) {}
  ResidualSpace space;
  CandidateSet set;
  SubsetSearch search;
};

}  // namespace mm
