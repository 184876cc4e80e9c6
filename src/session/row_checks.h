#pragma once
#include <vector>

#include "session/sense_checks.h"

namespace mm {

/// Asks about what needs no geometry: readings far beyond the machine's travel (another unit),
/// joints that are within their travels only when exchanged, deviations that are too large or too small for
/// any machine (positions, another unit), rows that are there twice, times that go back or last too long.
/// Each question has its evidence. Empty: nothing strange.
/// @param session prepared. @param travels whether readings beyond the travel are asked for: where the
/// geometry has already told which unit or joint is wrong, they need no question of their own.
std::vector<Doubt> rowDoubts(const Session& session, bool travels = true);

}  // namespace mm
