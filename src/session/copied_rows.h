#pragma once
#include <string>
#include <vector>

#include "session/session.h"

namespace mm {

/// SetAside::field of a whole row that stands in the session twice.
inline constexpr const char* kCopiedRow = "row";

struct CopiedRow {
  std::size_t row = 0;  // index of the observation
  std::string why;  // "is line 19 of c.csv once more, to the same time and the last digit; it is used once"
};

/// Rows that are another one once more, whose noise would be taken for smaller than it is: of the same time,
/// and nothing that was measured differs by a bit (a topic that was recorded twice); or ten in a row that are
/// to the last digit ten others, what was logged beside them, too (a run that was pasted or read twice).
/// @param session in the order of time.
std::vector<CopiedRow> copiedRows(const Session& session);

/// Rows that are to the last digit those that stand `distance` rows before them.
struct RepeatedStretch {
  std::size_t begin = 0, length = 0, distance = 0;  // rows
};

/// Stretches of rows that are there again at later times: pasted, or read twice. None where all that was
/// measured lies on steps of 0.1 um or more (rotary: 0.01 arcsec), known to 1.5 nm (1.5e-4 arcsec), round
/// numbers or not: a coarse resolution repeats itself.
/// @param session in the order of time. @param least rows of a stretch.
/// @param whole whether directions of travel and what was logged beside (temperatures) must be the same, too.
std::vector<RepeatedStretch> repeatedStretches(const Session& session, std::size_t least, bool whole);

}  // namespace mm
