#pragma once
#include <array>
#include <vector>

#include "session/session.h"

namespace mm {

/// A target is reached up to its deviation: positions closer than this share of the travel are one target.
constexpr double kSameTarget = 2e-3;

/// Deviations at one target position of an axis (um, or arcsec for a rotary one); s is NaN for fewer than two
/// runs.
struct PositioningTarget {
  double at = 0.0;  // mm or deg
  double meanForward = kNotMeasured, meanBackward = kNotMeasured;
  double sForward = kNotMeasured, sBackward = kNotMeasured;  // sample standard deviation of the runs
  int forward = 0, backward = 0;                             // runs
};

/// A, R and E of one direction of approach or of both, from the means and standard deviations of the runs.
struct ApproachFigures {
  double accuracy = kNotMeasured;       // largest of mean + 2 s, minus smallest of mean - 2 s
  double repeatability = kNotMeasured;  // largest of 4 s; of both also of 2 s + 2 s + |B| at a target
  double systematic = kNotMeasured;     // range of the means
};

/// Figures of ISO 230-2:2014, section 3, with its coverage factor of 2, in um (arcsec): bi-directional A, R
/// and E, and what else there is. NaN: there are too few runs.
struct PositioningFigures : ApproachFigures {
  ApproachFigures forward, backward;   // A, R and E with an arrow up or down
  double meanRange = kNotMeasured;     // M, range of the mean bi-directional deviation
  double reversal = kNotMeasured;      // B, largest |reversal error| of a target
  double meanReversal = kNotMeasured;  // mean of the reversal errors, with sign: forward minus backward
};

/// Each figure, in one order.
std::array<double*, 12> eachFigure(PositioningFigures& figures);

struct PositioningRun {
  double at = 0.0, deviation = 0.0;
  bool forward = true;
};

struct PositioningTest {
  std::vector<PositioningTarget> targets;  // ascending
  PositioningFigures figures;
  /// Standard uncertainties of the figures from the scatter of the runs alone, as of independent normal ones;
  /// NaN where a single run decides.
  PositioningFigures std;
};

/// @param runs deviations of one axis: actual minus target position.
PositioningTest positioningTest(std::vector<PositioningRun> runs);

}  // namespace mm
