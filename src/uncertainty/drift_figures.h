#pragma once
#include <vector>

#include "session/session.h"

namespace mm {

/// A displacement against time, from one reading of an instrument to the next.
struct DriftCurve {
  std::vector<double> hours;  // ascending
  std::vector<double> value;  // um, or arcsec
};

/// One figure of a drift, in the unit of its curve.
struct DriftFigure {
  double value = kNotMeasured;
  /// Its standard uncertainty by the noise of the readings alone; NaN: that is not known.
  double std = kNotMeasured;
  /// What independent noise of the readings adds to it on average: a range of noisy readings is too large by
  /// as much, a difference of two by nothing.
  double noise = kNotMeasured;
};

/// What heats the machine: from when to when, in the hours of its curves.
struct HeatedTime {
  double from = 0.0, to = 0.0;
  bool chosen = false;  // from the readings themselves, so that their noise has part in it
};

/// Figures of a drift (ISO 230-3). A displacement is that from the last reading before the heating began.
struct DriftFigures {
  DriftFigure range;      // largest minus smallest reading
  DriftFigure hour;       // the largest such range within any hour; NaN: shorter than an hour
  DriftFigure firstHour;  // displacement an hour after the beginning; NaN: not read for so long
  DriftFigure heated;     // displacement at the end of the heating
  DriftFigure recovery;   // displacement from the end of the heating to the last reading
};

/// @param curve values that are not finite do not count. @param noise standard deviation of one reading, in
/// the unit of the curve; NaN: not known. Share and uncertainty come from noise that is added to the smoothed
/// curve again and again, always the same; an end of the heating that was chosen is chosen anew each time, of
/// every course: of those it was not chosen from this is an upper bound.
/// What that adds to a displacement on average is part of its uncertainty.
DriftFigures driftFigures(const DriftCurve& curve, const HeatedTime& heated, double noise);

/// Each reading as the line through its neighbours has it.
std::vector<double> smoothed(const DriftCurve& curve);

/// From the first reading to the one at which the smoothed displacement is largest: the heating of a machine
/// of which nothing was recorded that tells of it.
HeatedTime heatedTime(const DriftCurve& curve);

}  // namespace mm
