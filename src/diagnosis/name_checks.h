#pragma once
#include "diagnosis/full_fit.h"

namespace mm {

/// A name must also predict: a cause that does not clearly lower the error of rows that were not seen may
/// act, and is not named.
void dropWhatPredictsNothing(Look& look);
/// A name has a size: where the fit of everything finds none, two models of the same noise contradict each
/// other, and the cause is as likely as not. @return whether one was dropped.
/// @param diagnosis with the sizes of what was found.
bool dropWhatHasNoSize(Look& look, const Diagnosis& diagnosis);

}  // namespace mm
