#pragma once
#include "session/session.h"

namespace mm {

/// Readings at one target differ by what the drive leaves; targets by more.
constexpr double kSameTarget = 20e-6;  // m or rad

/// Gives joints whose velocity was recorded nowhere in the session a direction of travel, and those that
/// stand at a reading though they were elsewhere at the one before, and says so in `Session::assumed`. For
/// recorded sessions only: a live one tells its motion, or does not know it.
///
/// At a touch: the tip moves along the approach into the surface (where it was not recorded: square to the
/// ball), so the joints move that produce it; one that the approach hardly moves keeps the order of
/// positions, which then hardly matters: a contact sees a joint's error in the same proportion. At a reading
/// of an independent instrument: from the order of positions. A target that is measured twice as often at a
/// turning point as elsewhere was overrun (ISO 230-2): its second half was approached in the new direction.
/// Neither speeds nor the travel of a laser's readings are made up.
/// @param session prepared. Calling it again changes nothing.
void assumeTravel(Session& session);

}  // namespace mm
