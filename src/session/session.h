#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "machine/controller_compensation.h"
#include "machine/machine.h"

namespace mm {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

enum class FeatureKind { kBall, kPoint };

/// A ball or a point of the artifact. Lengths in m, in the artifact's frame.
struct Feature {
  FeatureKind kind = FeatureKind::kBall;
  std::string name;
  /// Ball's centre or the point; a start value when free (NaN: `Session::prepare` makes one from the
  /// contacts).
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  bool known = true;
  double positionStd = 0.0;  // of a known position; 0: exact
  double radius = 0.0;
  double radiusStd = 0.0;  // 0: exact
};

/// One of the styli that a probe may carry. Lengths in m.
struct Stylus {
  std::string name;
  double tipRadius = 0.0;
  /// From the machine's probe_tip to this one's tip, in the axes of probe_tip; a start value when free (NaN:
  /// none).
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  bool known = true;  // the offset
};

/// What is measured. With `poseKnown` its frame is `workpiece`, else its pose is estimated.
struct Artifact {
  std::string name;
  std::string serial;  // empty: not stated
  bool poseKnown = true;
  std::vector<Feature> features;
  double tipRadius = 0.0;               // m
  double repeatability = kNotMeasured;  // m, standard deviation of one contact
  double expansion = 0.0;               // 1/K
  std::string temperatureSensor;
  std::vector<Stylus> styli;                       // empty: one, of `tipRadius` at the machine's probe_tip
  int findFeature(const std::string& name) const;  // -1 when absent
  int findStylus(const std::string& name) const;   // -1 when absent
  double tipRadiusOf(int stylus) const;            ///< m
};

/// A logged quantity against time, e.g. a temperature (degC) or a covariate (its own unit).
struct Series {
  std::string name;
  std::string unit;
  std::vector<double> time;  // s from the session's start, ascending
  std::vector<double> value;
  /// Linear between the neighbouring stamps, constant beyond the ends; NaN where nothing was logged.
  double at(double time) const;
};

/// What one row measured. A position is told by a tracker or a CMM; the deviation of one joint by an
/// interferometer, a step gauge or an autocollimator; the length from a place to the tip by a tracking
/// interferometer or a ball bar.
enum class ObservationKind { kContact, kPosition, kDeviation, kLength };

/// One contact of the probe, or one measurement by an independent instrument. SI units.
struct Observation {
  ObservationKind kind = ObservationKind::kContact;
  double time = 0.0;     // s from the session's start
  std::int64_t row = 0;  // where it came from: line of the CSV, or index of the message in its topic (from 1)
  std::vector<double> position;  // uncorrected readings in the order of the machine's joints
  std::vector<double> velocity;  // NaN: not known
  std::vector<double> travel;  // -1, +1: direction of the last motion; 0: not known. Made by Session::prepare
  Eigen::Vector3d approach =
      Eigen::Vector3d::Constant(kNotMeasured);  // unit vector in workpiece; NaN: not known
  double laserReading = kNotMeasured;           // m
  int feature = -1;  // index in the artifact: kContact: what was touched, kLength: where the length begins
  Eigen::Vector3d reference =
      Eigen::Vector3d::Constant(kNotMeasured);  // kPosition: true position, artifact frame
  double length = kNotMeasured;                 // kLength: from the feature's position to the tip, m
  std::vector<double> deviation;     // kDeviation: true minus indicated a joint, m or rad; NaN: not measured
  std::vector<double> deviationStd;  // NaN: not stated
  int setup = -1;                    // index in Session::setups: rows that share an unknown zero
  int placement = 0;                 // index in Session::placements
  int stylus = 0;                    // index in Artifact::styli
  int recording = 0;                 // index in Session::recordings
};

/// Session::timesAssumed of a file without times.
inline const char* const kTimesInOrder = "in the order of the rows";

/// A direction of travel that was not recorded and was made from what was.
struct AssumedInput {
  std::string joint;
  std::string how;     // "from the approach of the contact", "from the order of positions"
  double share = 0.0;  // of the observations
};

/// A row, or one logged value, that cannot be what was meant. It is kept (a bag that is written holds it),
/// but nothing is computed from it. Rows that are kept and have no weight in a fit: outliers
/// (estimation/robust.h), those that lack an input of the model (Problem::leftOut); in a diagnosis, those
/// before an axis first moved (Diagnosis::notJudged).
struct SetAside {
  struct LoggedValue {
    std::string series;
    bool temperature = false;
    double time = 0.0, value = 0.0;
  };
  std::int64_t row = 0;  // as Observation::row; 0: a value that was logged between the rows
  int recording = 0;     // as Observation::recording
  std::string field;     // "x", "x velocity", "time", "feature", "temperature bed"; kCopiedRow: all of it
  std::string value;     // with its unit
  std::string why;       // with the figures, and what to do
  std::optional<Observation> observation;  // the whole row
  std::optional<LoggedValue> logged;       // one value of a series
};

/// One of several sessions that were joined (session/joined.h).
struct Recording {
  std::string source, hash;
  std::string rowFile;            // as Session::rowFile
  double begin = 0.0;             // s from the start of the joined session
  std::string timesAssumed = {};  // as Session::timesAssumed
};

/// A measurement session, whatever it was read from (bag, CSV, live topics), or several of them joined.
struct Session {
  Machine machine;
  Artifact artifact;
  std::vector<Observation> observations;  // ascending in time
  std::vector<Series> temperatures;       // degC
  std::vector<Series> covariates;
  std::vector<std::string> setups;
  /// Where the artifact stood, or the frame of the reference positions: each has a pose of its own. One
  /// without a name is the artifact's own pose where that is known. Empty: one, without a name.
  std::vector<std::string> placements;
  std::vector<Recording> recordings;    // in the order of time; empty: this is one session
  double epoch = 0.0;                   // s, stamp of the session's start (t = 0)
  bool simulated = false;               // nobody measured it
  std::string source;                   // path, for messages
  std::string warning;                  // e.g. "read up to the damage at message 812"; empty: none
  ControllerCompensation compensation;  // that was active; errors are what remained beside it
  std::string rowFile;  // name of the file whose lines `Observation::row` counts; empty: messages
  std::vector<AssumedInput> assumed;  // made by assumeTravel
  /// How times that nobody recorded were made up ("in the order of the rows"): they tell the order of the
  /// observations and nothing else, so that no effect knows them (timed). Empty: they were recorded.
  std::string timesAssumed;
  std::vector<SetAside>
      setAside;  // by `prepare` and by who reads a bag: not in `observations`, not in the series

  explicit Session(Machine m) : machine(std::move(m)) {}  ///< nothing measured yet

  /// Sorts by time (stable; at equal times contacts first), derives the direction of travel (at standstill
  /// that of the last motion), checks every value, sets gross rows aside. Called by each reader; a second
  /// call changes nothing. @throw InputError naming source, row and field of a bad value.
  void prepare();
  bool hasLaser() const;
  int placementCount() const { return placements.empty() ? 1 : static_cast<int>(placements.size()); }
  /// Whether what stands there has an unknown pose: all but an artifact of known pose without a placement's
  /// name. Positions without an artifact have the frame of their instrument.
  bool poseFree(int placement) const;
  /// The first in which a feature was touched; 0: in none.
  int placementOf(int feature) const;
  int recordingCount() const { return recordings.empty() ? 1 : static_cast<int>(recordings.size()); }
  /// Whether one residual tells of the distance from a feature to the tip: +1: it grows with it (a contact
  /// with a ball), -1: it shrinks (a length: measured minus model), 0: it is none (all others).
  int outward(const Observation& o) const;
  /// s from the start of the recording that an observation belongs to.
  double ownTime(const Observation& o) const;
  /// The time of an observation was recorded.
  bool timed(const Observation& o) const;
  /// Where the readings say that the probe is, with the stylus that was used (without an offset: probe_tip).
  ProbePose nominalProbe(const Observation& o) const;
  /// "line 17 of plate.csv", or "row 17" where rows are messages.
  std::string rowText(std::int64_t row, int recording = 0) const;
};

}  // namespace mm
