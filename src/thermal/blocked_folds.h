#pragma once
#include <vector>

namespace mm {

/// One division of a series in time: fitted on `train`, judged on `test` (indices of samples).
struct Fold {
  std::vector<int> train;
  std::vector<int> test;
};

/// Divides `samples` in the order of time into `blocks` contiguous blocks, each held out once. `gap` samples
/// on both sides of the block are used for neither, so that neighbours in time do not give the answer away.
/// Throws InputError when there are fewer than 2 blocks or a fold would be empty.
std::vector<Fold> blockedFolds(int samples, int blocks, int gap = 0);

}  // namespace mm
