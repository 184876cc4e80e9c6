#pragma once
#include <vector>

#include "estimation/calibrate.h"
#include "uncertainty/circle_figures.h"

namespace mm {

/// Circles among what an independent instrument found: deviations of two linear axes, or positions, at
/// readings that lie on a circle, or an imported ball bar; empty for other sessions.
std::vector<CircleTest> circleTests(const CalibrationResult& fitted);

}  // namespace mm
