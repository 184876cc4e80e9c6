#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// Deviations at one target position of an axis (um, or arcsec for a rotary one); s is NaN for fewer than two
/// runs.
struct PositioningTarget {
  double at = 0.0;  // mm or deg
  double meanForward = kNotMeasured, meanBackward = kNotMeasured;
  double sForward = kNotMeasured, sBackward = kNotMeasured;  // sample standard deviation of the runs
  int forward = 0, backward = 0;                             // runs
};

/// Figures of ISO 230-2:2014, section 2, in um (arcsec). NaN: there are too few runs.
struct PositioningFigures {
  double accuracy = kNotMeasured;       // A, bi-directional accuracy of positioning
  double repeatability = kNotMeasured;  // R, bi-directional
  double repeatabilityForward = kNotMeasured, repeatabilityBackward = kNotMeasured;
  double systematic = kNotMeasured;  // E, bi-directional systematic deviation
  double meanRange = kNotMeasured;   // M, range of the mean bi-directional deviation
  double reversal = kNotMeasured;    // B, largest reversal error (signed as forward minus backward)
  double meanReversal = kNotMeasured;
};

struct PositioningRun {
  double at = 0.0, deviation = 0.0;
  bool forward = true;
};

struct PositioningTest {
  std::vector<PositioningTarget> targets;  // ascending
  PositioningFigures figures;
};

/// @param runs deviations of one axis: actual minus target position.
PositioningTest positioningTest(std::vector<PositioningRun> runs);

/// One axis of a session with an independent instrument, approached from both sides.
struct AxisPositioning {
  std::string axis;
  bool rotary = false;
  PositioningTest measured;    // as the machine is
  PositioningTest calibrated;  // what the model leaves
  std::vector<PositioningRun> runs, left;
};

/// Axes with at least three targets that were reached from both directions; empty for other sessions.
std::vector<AxisPositioning> axisPositioning(const CalibrationResult& fitted);

}  // namespace mm
