#pragma once
#include <limits>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "verification/trend_of_series.h"

namespace mm {

/// One parameter in one calibration, in its unit for people.
struct ParameterPoint {
  std::string id, created;  // of the calibration; ISO 8601, UTC
  std::string measured;     // start of its session; where that has no date, `created`
  double day = 0.0;         // of the measurement (without a date: of the calibration) since the first of all
  double value = 0.0, std = 0.0;
  bool comparable = true;  // false: the effect counts from another observed range than in the last one
};

/// How one parameter went through the calibrations of a machine.
struct ParameterTrend {
  EffectSpec effect;
  std::string name, unit;
  std::vector<ParameterPoint> points;  // as time goes
  /// Straight line through the comparable points, unit/day, with their scatter about it (trendOf). NaN: of
  /// less than a day.
  double slope = std::numeric_limits<double>::quiet_NaN(), slopeStd = slope;
  double change = 0.0, changeStd = 0.0;  // of the last against the first comparable point
  double pValue = 1.0;  // of a drift or step by chance (trendOf), corrected for all parameters asked (Holm
                        // 1979); of fewer than three comparable points, or less than a day, 1
  bool significant = false;  // below 0.01
  std::string inWords;
};

/// @param calibrations as they were made; those of another machine than the last are left out, and of several
/// of one session all but the last.
/// @return by effect and name, as in the last calibration and then those that are no longer in it.
std::vector<ParameterTrend> trendsOf(const std::vector<Calibration>& calibrations);

/// Ids of the calibrations that a later one of the same session (and machine) takes the place of.
std::vector<std::string> refitted(const std::vector<Calibration>& calibrations);
/// Whether the session's stamps are those of a clock: an import and a simulation have none.
bool hasDate(const Calibration& calibration);

/// Ids of the calibrations that are not of the machine of the last one.
std::vector<std::string> ofOtherMachines(const std::vector<Calibration>& calibrations);

/// Start of the calibration's session where that has a date, else when it was made; ISO 8601, UTC.
std::string measuredAt(const Calibration& calibration);
/// Days since 1970 of an ISO 8601 time in UTC (2026-03-01T09:30:00Z), or of a date alone; NaN: it is none.
double daysOf(const std::string& time);

}  // namespace mm
