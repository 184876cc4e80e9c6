#pragma once
#include <utility>
#include <vector>

#include "session/session.h"

namespace mm {

/// SetAside::field of a whole row that stands in the session twice.
inline constexpr const char* kCopiedRow = "row";

/// Rows that are another one once more: of the same time, and nothing that was measured differs by a bit. A
/// file that holds a run twice, a topic that was recorded twice: noise would be taken for smaller than it is.
/// @param observations in the order of time. @return index of the copy, index of the first of its kind.
std::vector<std::pair<std::size_t, std::size_t>> copiedRows(const std::vector<Observation>& observations);

}  // namespace mm
