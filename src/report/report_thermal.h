#pragma once
#include <string>
#include <vector>

#include "estimation/calibrate.h"
#include "uncertainty/thermal_tests.h"

namespace mm {

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
