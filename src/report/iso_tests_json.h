#pragma once
#include <vector>

#include "report/json_parts.h"
#include "report/report_circle.h"
#include "report/report_positioning.h"

namespace mm {

/// ISO 230-2 of each axis, as the page reads it: positions in mm or deg, deviations in um or arcsec.
Json positioningJson(const std::vector<AxisPositioning>& axes);
/// ISO 230-4 of each circle: angles in deg, deviations in um.
Json circlesJson(const std::vector<CircleTest>& tests);

}  // namespace mm
