#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"

namespace mm {

/// Course of the deviation at one position, in um or arcsec, against time in h from the session's start.
struct ThermalCourse {
  double at = 0.0;  // mm or deg
  std::vector<double> hours, measured, left;
  /// Largest minus smallest over the test: as measured, and what the model leaves.
  double measuredRange = 0.0, leftRange = 0.0;
};

/// Deviations of one axis against time beside the temperatures, in the manner of ISO 230-3.
struct AxisThermal {
  std::string axis;
  bool rotary = false;
  std::vector<ThermalCourse> courses;           // the first, middle and last position, ascending
  double measuredRange = 0.0, leftRange = 0.0;  // the largest over all positions
};

struct TemperatureCourse {
  std::string sensor;
  std::vector<double> hours, temperature;  // degC
};

struct ThermalTest {
  std::vector<AxisThermal> axes;
  std::vector<TemperatureCourse> temperatures;  // those of the learned networks first; at most 12
};

/// Axes that an independent instrument measured at the same positions at least five times, over at least ten
/// minutes and while a temperature changed by at least 0.5 K; empty for other sessions.
ThermalTest thermalTest(const CalibrationResult& fitted);

}  // namespace mm
