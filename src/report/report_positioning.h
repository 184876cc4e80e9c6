#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"
#include "uncertainty/positioning_figures.h"

namespace mm {

/// One axis of a session with an independent instrument, approached from both sides, nothing else moving;
/// one a line of the machine's volume and a zero of the instrument.
struct AxisPositioning {
  std::string axis;
  std::string name;           // "x", or "x, setup left", "x, at y = 100 mm" where there are several
  std::string travelAssumed;  // where the direction of approach was not recorded: how it was made up
  bool rotary = false;
  PositioningTest measured;    // as the machine is
  PositioningTest calibrated;  // what the model leaves
  std::vector<PositioningRun> runs, left;
};

/// Axes with at least three targets that were reached from both directions; empty for other sessions. Every
/// measured run counts, what a fit calls an outlier too: the standard leaves none out.
std::vector<AxisPositioning> axisPositioning(const CalibrationResult& fitted);

}  // namespace mm
