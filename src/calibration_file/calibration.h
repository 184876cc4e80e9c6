#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "effects/domain.h"
#include "effects/effect_spec.h"
#include "effects/learned_network.h"
#include "machine/controller_compensation.h"

namespace mm {

/// One step of the ledger: what was done to the model and what it did to the error.
struct LedgerEntry {
  std::string action;                  // "calibrate", "add" or "remove"
  EffectSpec effect;                   // empty type for "calibrate"
  std::string time;                    // ISO 8601, UTC
  double rmsBefore = 0, rmsAfter = 0;  // m (rad where the session has angular residuals only); NaN: none
  double heldOutBefore = 0, heldOutAfter = 0;  // m
  std::string calibration;            // id of the calibration before the step: what it can be taken back to
  std::vector<std::string> sessions;  // by which it was judged, where these were several
};

/// One of several sessions by which a machine was calibrated.
struct SessionPart {
  std::string source, hash;
};

/// A feature as a calibration found it in the artifact's frame. SI units.
struct FoundInArtifact {
  std::string name;
  bool ball = true, free = false;  // free: estimated, or its deviation from the file was
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), std = Eigen::Vector3d::Zero();
  double radius = 0.0, radiusStd = 0.0;
};

/// How the machine drifts along one direction, which no parameter describes.
struct Wandering {
  std::string direction;      // a joint, or x, y, z of workpiece
  double std = 0.0;           // m (rad for a rotary joint)
  double timeConstant = 0.0;  // s
  bool smooth = false;        // Matern 3/2; else an Ornstein-Uhlenbeck process
};

/// The artifact by which a machine was calibrated, as its file stated it. SI units.
struct CalibratedBy {
  std::string name;
  std::int64_t features = 0;  // balls and points; 0: an independent instrument, or not told
  bool poseKnown = true;
  double tipRadius = 0.0;  // m
  double span = 0.0;       // m, largest distance of two features of known position; 0: fewer than two
  double centreStd = 0.0;  // m, largest standard uncertainty of a known position; 0: taken as exact
  double radiusStd = 0.0;  // m, largest of a ball's radius; 0: taken as exact
  std::string serial = {};
  std::vector<FoundInArtifact> found = {};  // empty: the file does not tell
};

/// A calibration: the model, its parameters and where it holds. Complete in itself (the URDF is inside). SI
/// units.
struct Calibration {
  struct Value {
    int effect = 0;  // index in `effects`
    std::string name;
    std::string unit;     // for people
    double toUnit = 1.0;  // value in unit = SI * toUnit
    double value = 0.0;   // SI
    double std = 0.0;     // SI; 0 when fixed
    bool fixed = false;   // by a gauge convention
  };

  std::string id;        // made by the writer: UTC stamp and first digits of the checksum
  std::string created;   // ISO 8601, UTC
  std::string software;  // package version
  std::string machineName;
  std::string urdf;
  Domain domain;
  std::vector<EffectSpec> effects;
  std::vector<LearnedNetwork> networks;  // of those effects whose shape is learned
  std::vector<Value> values;             // in the order of the model's parameters
  Eigen::MatrixXd covariance;            // SI, of `values`

  std::vector<Wandering>
      drift;  // what the session showed beside white noise; the corrected point may be off by it

  std::optional<CalibratedBy> artifact;  // empty: the file does not tell
  std::string sessionSource;
  std::string sessionHash;
  std::vector<SessionPart> sessionParts;  // of several sessions that were judged together; empty: of one
  /// Namespace of the nodes that measured ("/m1"); empty: not measured by nodes (imported, simulated).
  std::string sessionSpace;
  std::string sessionOrigin;  // "simulated"; empty: not told
  bool toldSpace = true;      // false: a file that was written before this was told
  /// Stamp of the session's start, s: what `t = 0` is on the clock of its source. NaN: not known.
  double sessionEpoch = std::numeric_limits<double>::quiet_NaN();
  ControllerCompensation compensation;  // that was active: the model is what remained beside it
  std::string method;
  std::uint64_t seed = 0;
  std::int64_t observations = 0;
  double rms = 0, heldOutRms = 0;                // m; NaN: no residuals in m
  double rmsAngular = 0, heldOutRmsAngular = 0;  // rad; NaN: no angular residuals
  double chi2PerDof = 0;
  double degreesOfFreedom = 0;    // of the residuals; 0: the file does not tell
  double repeatability = 0;       // m (or rad), as used
  std::string repeatabilityFrom;  // declared, repeated or estimated
  std::vector<LedgerEntry> ledger;
};

}  // namespace mm
