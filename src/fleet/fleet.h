#pragma once
#include <limits>
#include <string>
#include <vector>

#include "fleet/fleet_database.h"
#include "fleet/sisters.h"
#include "verification/trend_of_series.h"

namespace mm {

/// What a series is about.
enum class SeriesKind { kParameter, kFigure, kSensor };

/// One quantity of one machine over its sessions.
struct FleetSeries {
  SeriesKind kind = SeriesKind::kParameter;
  std::string machine;
  std::string quantity;  // "gap of {type: backlash, axis: x}", "held-out RMS", "offset of sensor bed"
  std::string unit;
  double resolution = 0.0;         // of a sensor's offset: less than this is no change; 0: any is
  std::vector<TrendPoint> points;  // day: from 1970, UTC
  std::vector<std::string> dates;  // of the points
  Trend trend;
};

/// One thing that somebody should know about a fleet.
struct Finding {
  std::string kind;  // changed, drifts, apart, drifts_apart, came_back, sensor
  std::string machine, quantity, unit = {};
  std::string inWords = {};  // one sentence with its figures
  bool change = false;       // at one time, from one level to another
  std::string date = {};     // of the change, as far as it has one
  double before = 0.0,
         after = 0.0;  // levels (in a drift: first and last value; apart: the sisters', its own)
  /// Standard uncertainty of after - before, of `changed`, `came_back` and `drifts`; NaN: not told.
  double std = std::numeric_limits<double>::quiet_NaN();
  double p = 1.0;  // of it by chance, for this question alone
};

struct FleetOptions {
  std::string machine;    // empty: all
  std::string parameter;  // part of the quantity's name; empty: all
  std::string model;      // the model's path, or part of it; empty: the one with most jobs
  double alarm = 0.01;    // chance that a quiet fleet gives any finding at all
};

/// A fleet's year at one look.
struct Fleet {
  std::string source;  // folder, for messages
  std::string model;   // whose parameters are compared
  std::vector<std::string> otherModels;
  std::vector<std::string> machines;
  long done = 0, failed = 0, waiting = 0;  // waiting: planned and not done
  long open = 0;                           // done, but the fit did not converge: its values are in no series
  std::vector<FleetRecord> failures;
  std::vector<FleetRecord> records;  // done, of the model
  std::vector<FleetSeries> series;   // by quantity, then machine
  std::vector<Finding> findings;     // the surest first
  double questions = 0.0;            // among which the chance of a false alarm is shared
  double alarm = 0.0;
};

/// Reads `folder`: results of mm batch, or stores of calibrations (one, or a folder of several machines').
/// @throw InputError: neither, damaged, or nothing is left by the options.
Fleet loadFleet(const std::string& folder, const FleetOptions& options);
/// The same from records.
Fleet fleetOf(std::vector<FleetRecord> records, const FleetOptions& options);

/// Calibrations kept in a store, or in the stores of several machines (one folder each), as records, one a
/// session: what was made active last of those that a session gave, else the last. Machine is the folder's
/// name, else the serial, else the machine's name; model is the list of effects. @throw InputError: there is
/// none.
std::vector<FleetRecord> storeRecords(const std::string& folder);

/// What a machine has now: the level of its last segment, of a drift the end of its line, with its standard
/// uncertainty.
Sister presentOf(const FleetSeries& series);

/// Private to this folder: the steps of fleetOf.
std::vector<FleetSeries> seriesOf(const std::vector<FleetRecord>& records);  ///< of converged fits, sensors
void findTrends(Fleet& fleet, double alpha);                                 ///< changed, drifts
void findSisters(Fleet& fleet, double alpha);                                ///< apart, drifts_apart
void findRecurrences(Fleet& fleet, double alpha);                            ///< came_back
void findBadSensors(Fleet& fleet);  ///< sensor: stuck, lost, error codes
void condense(Fleet& fleet);        ///< of one cause one finding
/// How many questions findSisters and findRecurrences will ask.
double sisterQuestions(const Fleet& fleet);
double recurrenceQuestions(const Fleet& fleet);

// Outputs: as text for people, as JSON, as CSV of all values, as one page without a network.
std::string fleetText(const Fleet& fleet);
std::string fleetJson(const Fleet& fleet,
                      bool everything);  ///< @param everything also each point of each series
std::string fleetCsv(const Fleet& fleet);
std::string fleetPage(const Fleet& fleet);

}  // namespace mm
