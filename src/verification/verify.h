#pragma once
#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calibration_file/calibration_store.h"
#include "estimation/calibrate.h"
#include "session/session.h"
#include "verification/hypotheses.h"
#include "verification/loaded_export.h"

namespace mm {

/// Did it help? One word for a decision.
enum class VerifyVerdict { kHelped, kNoChange, kWorse, kMixed };
std::string nameOf(VerifyVerdict verdict);  ///< "helped", "no_change", "worse", "mixed"

struct VerifyOptions {
  bool loaded = false;                           // the controller corrected while the session was measured
  std::shared_ptr<const LoadedExport> exported;  // with these tables; null: with the whole correction
  CalibrateOptions calibrate;
};

/// How much of an error remains after the correction: 0 it is gone, 1 as before, 2 twice as large.
struct RemainingShare {
  double size = 0.0;       // m (rad): RMS of the uncorrected error at these points
  double remaining = 0.0;  // share
  double std = 0.0;        // of `remaining`; 10 and more: these points do not tell
  std::string inWords;     // "corrected", "not corrected", "wrong sign" …
};
struct RemainingOfAxis : RemainingShare {
  std::string axis;
};
struct RemainingOfEffect : RemainingShare {
  EffectSpec effect;
  /// Share that the tables of an export leave: no fault of the loading, no drift. `remaining` is of what they
  /// carry. Below 0: they carry, in the shape of this effect, a part of another one.
  double notCarried = 0.0;
};

/// A share of one axis's correction that appears as an error of another axis.
struct CrossedShare {
  std::string of, on;
  double share = 0.0, std = 0.0;
};

/// An effect whose size is no longer the calibrated one.
struct ChangedEffect {
  struct Parameter {
    std::string name, unit;
    double change = 0.0, std = 0.0;  // in `unit`
  };
  EffectSpec effect;
  std::vector<Parameter> parameters;
  double pValue = 1.0;
};

/// Another explanation that these points do not exclude.
struct VerifyRival {
  std::string inWords;
  double odds = 0.0;  // against the best, below 1
};

/// An RMS with its standard uncertainty, m (rad where the session has angular residuals only).
struct Figure {
  double rms = 0.0, std = 0.0;
};

/// Why no point of this session is fresh for a calibration, with what to do; empty: nothing says so.
std::string whyNotFresh(const Calibration& calibration, const Session& session);

/// Which hypothesis the points speak for, and what none of them explains.
struct Decision {
  LoadedHow hypothesis;
  bool tablesSeen = true, offsetsSeen = false;  // false: these points cannot show the tables, the offsets
  bool drifted = false;                         // more is wrong than any way of loading explains
  std::vector<ChangedEffect> changed;           // since the calibration, most certain first
  double unexplainedPValue = 1.0;               // of what is left after all this: chance
  std::vector<VerifyRival> rivals;              // best first, at most four
};

/// RMS before and after the correction.
struct BeforeAndAfter {
  Figure before, after;
  bool angular = false;     // in rad: there are no residuals in m
  int residuals = 0;        // of that kind
  double noise = 0.0;       // m (rad): of one residual, as these points show it
  double unforeseen = 0.0;  // m (rad): RMS of what the hypothesis leaves of the points
};

/// What the points of a fresh session say of a calibration.
struct Verification : Decision, BeforeAndAfter {
  VerifyVerdict verdict = VerifyVerdict::kMixed;
  std::string finding;  // "corrected", "not_corrected", "wrong_sign", "corrected_twice", "exchanged",
                        // "partly", "too_small"
  std::string inWords;  // one to three sentences
  bool loaded = false;
  bool better = false;      // after is significantly below before
  std::string target;       // of the export that was named; empty: none
  double notCarried = 0.0;  // m (rad): RMS of what neither its tables nor its offsets correct at these points
  std::optional<RemainingShare> offsets;  // of the export; empty: it has none
  /// m (rad): what the calibration left of its own session, held out; NaN: not known.
  double calibratedRms = 0.0;
  /// Chance of as much beyond what was foreseen where the machine is as the calibration left it (F test
  /// against calibratedRms); NaN: not known.
  double moreLeftPValue = std::numeric_limits<double>::quiet_NaN();
  bool moreLeft = false;  // that chance is below 0.001
  int observations = 0;
  std::vector<RemainingOfAxis> axes;
  std::vector<RemainingOfEffect> effects;
  std::vector<CrossedShare> crossed;  // those that are there, significantly
  std::vector<Outlier> outliers;      // left out
};

/// Compares a session of fresh points with a calibration; no parameter of the calibration is refitted.
/// Loaded: the readings should be free of error; else they are raw, and the correction should explain them.
/// The residual is regressed on the correction's field by generalised least squares (noise with memory by
/// REML, the calibration's covariance as prior of its parameters), and the ways in which a table can be
/// loaded wrongly are compared by their likelihoods (docs/verification.md).
/// @param session must outlive the call. @throw InputError: another machine, nothing to verify, an input of
/// the model was not recorded, the session states another compensation than was loaded. @throw
/// NumericalError: too few points. @throw Cancelled.
Verification verify(const Session& session, const Calibration& calibration, const VerifyOptions& options);

/// Keeps an answer where the calibration is kept, for its history and its certificate. The answer stands
/// whether or not it could be kept. @return why it could not; empty: it was, or the store has no such
/// calibration.
std::string keepAnswer(const CalibrationStore& store, const Calibration& calibration, const Session& session,
                       const Verification& found);

}  // namespace mm
