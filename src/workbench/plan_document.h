#pragma once
#include <string>

#include "machine/machine.h"

namespace mm {

/// What a plan will do on a machine, as the page draws it before it runs: `text` as it was given, balls and
/// points (mm), how many moves and measurements, an estimate of its time (s: rapid travel, approaches and
/// waits, without acceleration), and of each measurement where the tip begins (`from_mm`), where it meets the
/// surface or reads (`to_mm`; both workpiece, three numbers each), what it touches (index of the ball or
/// point, -1: none), the readings there (mm, deg; one a joint) and the line of the plan; `way_mm`: where the
/// tip goes, move after move. Of a long plan only the first measurements are drawn: `left_off` says how many
/// are not.
/// @param yaml a plan as a page sends it; no file that it names is opened. @throw InputError as the plan's
/// reader and sentPlan().
std::string planDocument(const std::string& yaml, const Machine& machine);

}  // namespace mm
