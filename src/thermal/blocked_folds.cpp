#include "thermal/blocked_folds.h"

#include <string>

#include "base/error.h"

namespace mm {

std::vector<Fold> blockedFolds(int samples, int blocks, int gap) {
  if (blocks < 2 || blocks > samples)
    throw InputError("cross-validation: " + std::to_string(blocks) + " blocks of " + std::to_string(samples) +
                     " samples; give at least 2 blocks and no more than there are samples");
  if (gap < 0)
    throw InputError("cross-validation: the gap is " + std::to_string(gap) + "; it must not be negative");
  std::vector<Fold> folds(static_cast<std::size_t>(blocks));
  for (int b = 0; b < blocks; ++b) {
    const int begin = static_cast<int>(static_cast<long>(samples) * b / blocks);
    const int end = static_cast<int>(static_cast<long>(samples) * (b + 1) / blocks);
    Fold& fold = folds[static_cast<std::size_t>(b)];
    for (int i = 0; i < samples; ++i) {
      if (i >= begin && i < end)
        fold.test.push_back(i);
      else if (i < begin - gap || i >= end + gap)
        fold.train.push_back(i);
    }
    if (fold.train.empty())
      throw InputError("cross-validation: a gap of " + std::to_string(gap) + " leaves nothing to fit of " +
                       std::to_string(samples) + " samples; make it smaller");
  }
  return folds;
}

}  // namespace mm
