#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"
#include "uncertainty/circle_figures.h"
#include "uncertainty/positioning_figures.h"
#include "uncertainty/thermal_tests.h"

namespace mm {

// The tests of ISO 230 that a fitted session holds, as measured and as the model leaves them.

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

/// Circles among what an independent instrument found: deviations of two linear axes, or positions, at
/// readings that lie on a circle, or an imported ball bar; empty for other sessions.
std::vector<CircleTest> circleTests(const CalibrationResult& fitted);

/// A test of ISO 230-3 with the figures of each of its courses.
struct ThermalTestFigures {
  ThermalTest test;
  std::vector<DriftFigures> measured, left;  // of each course
};

struct TemperatureCourse {
  std::string sensor;
  std::vector<double> hours, temperature;  // degC
  double range = 0.0;                      // K, largest minus smallest
};

struct ThermalReport {
  std::vector<ThermalTestFigures> tests;
  std::vector<TemperatureCourse> temperatures;  // those of the learned networks first; at most 12
};

/// The tests of ISO 230-3 that a session holds (thermalTests), as measured and as the fitted model leaves
/// them; the noise is the repeatability, where that was declared or found from repeats.
ThermalReport thermalReport(const CalibrationResult& fitted);

}  // namespace mm
