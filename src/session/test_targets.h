#pragma once
#include <vector>

namespace mm {

/// The fewest targets of a line of that length (m): five per metre, five at least (ISO 230-2, 5.3.1, axes up
/// to 2 m; ISO 230-6 takes them over).
int fewestTargets(double length);

/// Targets over a span about zero, each a part of an interval beside equal spacing, lest the period of a
/// screw or of a scale is met at one phase only (ISO 230-2, 5.3: (i - 1) p + r). @param span m or rad.
std::vector<double> shiftedTargets(int count, double span);

}  // namespace mm
