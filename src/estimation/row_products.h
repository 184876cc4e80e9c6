#pragma once
#include "estimation/drift.h"

namespace mm {

/// a' b of two tall matrices with the same rows (one observation each): columns of a x columns of b. Uses the
/// widest arithmetic that the processor has, so its last bits differ between kinds of processors, but not
/// between runs on one of them.
RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a, const Eigen::Ref<const RowMatrix>& b);

/// a' a, the whole square.
RowMatrix rowProducts(const Eigen::Ref<const RowMatrix>& a);

}  // namespace mm
