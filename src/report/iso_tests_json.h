#pragma once
#include <vector>

#include "report/iso_tests.h"
#include "report/json_parts.h"
#include "uncertainty/diagonal_tests.h"
#include "uncertainty/length_tests.h"
#include "uncertainty/rotation_tests.h"

namespace mm {

/// ISO 230-2 of each axis, as the page reads it: positions in mm or deg, deviations in um or arcsec.
Json positioningJson(const std::vector<AxisPositioning>& axes);
/// ISO 230-4 of each circle: angles in deg, deviations in um.
Json circlesJson(const std::vector<CircleTest>& tests);
/// ISO 230-6 of each diagonal, as positioningJson().
Json diagonalsJson(const std::vector<DiagonalTest>& tests);
/// ISO 230-7: angles in deg, error motions in um; null: there is none.
Json rotationJson(const RotationTest& test);
/// ISO 10360-2: lengths in mm, errors in um.
Json lengthsJson(const std::vector<LengthLineTest>& tests);
/// ISO 230-3: time in h, displacements in um or arcsec, symbols of ISO 230-1 where an axis has them.
Json thermalJson(const ThermalReport& report, const Machine& machine);

}  // namespace mm
