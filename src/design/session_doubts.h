#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// What is likely wrong with a session or poor in it, one line each, with the remedy; empty: nothing.

/// Of the postures: a rotary joint with one angle only or with angles of one sign, a laser with one reading
/// only, readings far from all others.
std::vector<std::string> postureDoubts(const Session& session);

/// A declared repeatability that is far above the scatter of the residuals: another unit, most likely.
std::vector<std::string> repeatabilityDoubts(const CalibrationResult& result);

/// Of a fit: the declared repeatability; beams that miss their ball; a joint whose sign is likely wrong,
/// which is tried where the residual is far above the noise: with its readings reversed the residual falls to
/// a small part.
std::vector<std::string> fitDoubts(const CalibrationResult& result);

}  // namespace mm
