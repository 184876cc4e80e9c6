#pragma once
#include <vector>

#include "diagnosis/diagnose.h"
#include "diagnosis/round.h"

namespace mm {

/// Alternatives to one member of a subset, after refit of everything else: another effect in its place, or
/// in the place of all members of its cause, where needed with the help of one more.
/// @param rivals gets the best candidates in the member's place alone.
std::vector<Confusable> alternatives(const Round& round, const Subset& subset, std::size_t member,
                                     std::vector<Gain>& rivals);

}  // namespace mm
