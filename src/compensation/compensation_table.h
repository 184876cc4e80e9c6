#pragma once
#include <string>

#include "compensation/compensator.h"

namespace mm {

/// A calibration as the table of a controller: what it has to add to a commanded position so that the tip
/// goes where the command says, at the nodes of a grid over the calibrated volume. CSV: `<joint>_mm` of each
/// linear joint, `<joint>_travel` (-1, +1) of each joint whose direction matters, `correction_<joint>_um`.
/// What a table of places cannot hold is taken where it was in the middle of the calibration: rotary joints,
/// temperatures, covariates; velocity 0; time at the session's start.
/// @param points along each joint, 2 to 101. @throw InputError: a node whose correction is not known, with
/// the reason; no linear joint.
std::string compensationTable(const Compensator& compensator, int points);

}  // namespace mm
