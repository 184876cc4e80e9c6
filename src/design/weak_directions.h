#pragma once
#include <string>
#include <utility>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// A combination of the effects' parameters that a calibration knows much less than the others.
struct WeakDirection {
  std::vector<std::pair<int, double>>
      direction;             // unknown, component in units of what it alone would show; largest first
  double timesMedian = 0.0;  // its standard deviation over that of the middle direction
  std::string inWords;       // "y32 (± 77 um), x43 (± 98 um) and l (± 0.0006) are strongly correlated"
};

/// The principal directions of the covariance that stand out, weakest first.
std::vector<WeakDirection> weakDirections(const CalibrationResult& result);

}  // namespace mm
