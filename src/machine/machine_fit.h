#pragma once
#include <string>

#include "machine/machine.h"

namespace mm {

/// What tells this machine from others of its make: the text of `<serial>` in `<robot>`; empty: not stated.
std::string serialOf(const Machine& machine);

/// What the calibrated machine has and another has instead, of all that a calibration depends on: joints with
/// their order and kind, where they stand, along or about what they move, where the tip stands and how the
/// probe points, and the serial number where both state one; where not both do, the name in the URDF: two
/// machines of one build have the same chain. Limits, looks and comments of the URDF do not count.
/// @param there what the other is called: "in the session", "here". @return words for people; empty: they are
/// the same.
std::string differenceOf(const Machine& calibrated, const Machine& other, const std::string& there);

}  // namespace mm
