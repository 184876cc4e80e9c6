#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "design/next_measurement.h"
#include "effects/effect.h"
#include "estimation/calibrate.h"
#include "session/sense_checks.h"

namespace mm {

/// A share of the residual's variance that one variable explains, in any direction.
struct WhereItFails {
  std::string variable;  // "x", "x travel direction", "temperature bed", "time", "ball", …
  double share = 0.0;    // of the residual variance, adjusted for the number of terms; 0 … 1
  double pValue = 1.0;   // corrected for the number of variables asked
  double shareBeside = 0.0, pBeside = 1.0;  // the same of what the variables before it in the list leave
};

/// One estimated parameter of a missing effect, in its unit for people.
struct NamedValue {
  std::string name, unit;
  double value = 0.0, std = 0.0;  // std 0: the session does not determine it
};

/// An explanation that the data do not separate from the one that is named.
struct Confusable {
  EffectSpec effect;
  double delta = 0.0;  // log evidence of the named one minus that of this one, nats; below 3
  double odds = 0.0;   // posterior probability of this one among the named one and all its rivals, 0 … 1
  /// The two do the same wherever measurements of the session's kind reach: none separates them.
  bool same = false;
  /// Not empty: an input of it that the session did not record, so that it can only be excluded by recording
  /// it.
  std::string notRecorded;
  std::string moves;  // in words, how well the proposed moves separate it; empty where `same`
  int repeats = 0;    // of Diagnosis::nextMeasurement that separate it; 0: no practicable number does
};

/// One effect of the catalogue, judged on the session.
struct CandidateResult {
  EffectSpec effect;
  std::vector<NamedValue> parameters;
  double gain = 0.0;    // log evidence with it minus without, nats: beside what was found, or alone
  double odds = 0.0;    // posterior probability that it acts, given what was found, 0 … 1
  double pValue = 1.0;  // a bound from `gain`, corrected for every cause that was asked
  double heldOutBefore = 0.0, heldOutAfter = 0.0;  // RMS, m (rad for angular sessions)
  double size = 0.0;  // RMS of its contribution after refit, m (rad for angular sessions)
  std::vector<Confusable> confusableWith;
  std::string looksTheSame;  // Effect::looksTheSame(): a sentence, or nothing
  std::string cause, remedy;
};

/// A cause that is not named and that cannot be excluded either.
struct PossibleCause {
  EffectSpec effect;
  double odds = 0.0;    // posterior probability that it acts, at least kPossible
  std::string shownBy;  // Effect::shownBy(): what a measurement must contain to decide
};

/// A smooth function of one recorded variable, or of two, that no effect of the catalogue explains.
struct ProfileResult {
  EffectSpec effect;                               // type profile: ready to be added
  std::string direction;                           // a joint, x, y, z of workpiece, or approach
  std::vector<std::string> variables;              // one or two, as in formulas
  std::vector<std::string> units;                  // of the variables: "mm", "deg", "s", "degC" …
  double gain = 0.0, odds = 0.0;                   // as in CandidateResult
  double heldOutBefore = 0.0, heldOutAfter = 0.0;  // m (rad)
  /// Of one variable: its value (in `units`), the error, its standard deviation (um; arcsec for rotary). Of
  /// two: both values, the error, its standard deviation.
  std::vector<std::vector<double>> curve;
};

/// A formula of at most three constants that is equivalent to a profile.
struct FormulaResult {
  EffectSpec effect;                               // type formula: ready to be added
  EffectSpec profile;                              // in whose place
  double heldOutBefore = 0.0, heldOutAfter = 0.0;  // m (rad)
};

/// What the errors do in time that no recorded cause explains.
struct DriftResult {
  std::string direction;      // a joint, x, y, z of workpiece, or approach
  double std = 0.0;           // m (rad)
  double timeConstant = 0.0;  // s; 0: not known, no times were recorded
  struct Perhaps {
    EffectSpec effect;
    double odds = 0.0;   // posterior probability against drift alone, 0 … 1
    double share = 0.0;  // of the drift's variance that it takes over, 0 … 1
  };
  std::vector<Perhaps> perhaps;  // likeliest first
  std::string inWords;           // one sentence with what to do
  bool quick = false;     // quicker than the measurements follow one another: it is scatter of this direction
  double quickStd = 0.0;  // m (rad): of that part of it which is
  bool ofThePlace = false;  // and it is the same in each run over the same targets
};

// What an axis has for itself each time: these, then the name of its joint.
constexpr const char* kPositionsOf = "positions of ";
constexpr const char* kRunsOf = "runs of ";
constexpr const char* kPassesOf = "passes of ";  // a run in one direction
constexpr const char* kStopsOf = "stops of ";
constexpr const char* kScaleOf = "scale of ";
/// What displaces an artifact of known pose as a whole.
constexpr const char* kDatum = "datum";

/// Scatter that belongs to places: deviations of the artifact's balls from the file in position, radius or
/// form; of an axis from position to position, the same in each run; or from run to run, or stop to stop.
struct ArtifactScatter {
  std::string what;      // "centres", "radii", "form", "positions of x", "runs of x" …, kDatum
  double std = 0.0;      // m (rad)
  bool angular = false;  // `std` is rad
  std::string inWords;
  double stdStd = 0.0;          // of a standard deviation of so many, its standard uncertainty; 0: not stated
  EffectSpec correctedBy = {};  // of positions: the effect that holds them; no type: they are too many for it
};

/// The joint of which it is; empty: it is of the artifact.
std::string jointOf(const ArtifactScatter& scatter);

/// A cause that explains as well what something else was found to explain.
struct Alternative {
  EffectSpec effect;
  double probability = 0.0;  // posterior, beside what it competes with, 0 … 1
};

constexpr const char* kTime = "time";

/// An effect of the model whose size is not the same everywhere, or whose shape is not the model's alone.
struct Variation {
  EffectSpec effect;
  std::string along;  // the joint over which its size changes, or kTime; empty: its shape is another
  double rms = 0.0,
         std = 0.0;    // m (rad) at the measurements: what is left of it, and its standard uncertainty
  EffectSpec formula;  // follows it, ready to be added; of no type where none does, or it is there already
  std::vector<Alternative> instead;  // causes that may be taken for it, likeliest first
};

/// An input that was not recorded: what was assumed in its place, and what could act without being seen.
struct MissingInput {
  std::string input;    // "direction of travel of x", "speed of y" …
  std::string assumed;  // how it was made up ("from the approach of the contact"); empty: it was not
  std::vector<EffectSpec> effects;  // cannot be excluded without it
};

struct CannotShow {
  EffectSpec effect;
  std::string why, moves;
};

enum class Verdict {
  kQuestion,
  kInsufficientData,
  kUnknownEffect,
  kConfusable,
  kMissingEffect,
  kScatter,
  kExplained
};
/// As in JSON: "missing_effect".
std::string nameOf(Verdict verdict);

/// Observations at which the direction of travel of a joint, or its way since its last reversal, is not
/// known, and by which no cause is judged.
struct NotJudged {
  std::string joint;
  int observations = 0;
  bool directionKnown = false;  // at all of them: what is not known is the way since the last reversal
};

/// Readings that were set aside as outliers, by which no cause was judged.
struct OutliersSetAside {
  int readings = 0;
  double largest = 0.0;  // m (rad), magnitude
  /// What so many have in common by chance in one session of a hundred at the most: "of b5", "one after the
  /// other"; empty: nothing.
  std::string inCommon;
};

struct Diagnosis {
  std::vector<Doubt> questions;  // what must be answered first: then no cause is named
  CalibrationResult base;        // the model as it is, refitted to the session
  Verdict verdict = Verdict::kExplained;
  std::string sentence;  // the verdict in words
  std::vector<WhereItFails> where;
  std::vector<CandidateResult> missing;     // accepted, in the order found
  std::vector<PossibleCause> possible;      // likeliest first
  std::vector<CandidateResult> candidates;  // the causes asked, best first; of a long session the likely ones
  std::vector<ProfileResult> profiles;      // accepted: what no effect of the catalogue explains
  std::vector<FormulaResult> formulas;      // where one is equivalent to a profile
  std::vector<DriftResult> drift;
  std::vector<ArtifactScatter> artifactScatter;
  std::vector<Variation> variations;  // where nothing else was found, the largest first
  std::vector<MissingInput> missingInputs;
  double noise = 0.0;       // m (rad): the white part of what is left, as estimated
  double noiseStd = 0.0;    // its standard uncertainty
  double resolution = 0.0;  // m (rad): step of readings that are coarser than their noise; 0: finer
  std::vector<NotJudged> notJudged;
  OutliersSetAside outliers;
  int asked = 0, residuals = 0;  // by which causes were found; by which their sizes are
  double tailDof = 0.0;       // degrees of freedom of Student's t where the noise has heavy tails; 0: normal
  double chainsDiffer = 0.0;  // largest difference of a probability between the chains; 0: they agree
  /// RMS of rows that were not seen, m (rad): with nothing found, and with everything, fitted without the
  /// rows judged. By `diagnose` drift is predicted from its neighbours; `diagnoseCalibration` puts figures
  /// without that in its place, as those of `base.figures` and of the ledger, and as a corrected machine has.
  double heldOutBefore = 0.0, heldOut = 0.0;
  std::vector<CannotShow> cannotShow;
  std::vector<Move> nextMeasurement;
  std::string moveChange;  // what is changed before these, in words: the artifact turned, another stylus
  bool angular = false;    // RMS figures are rad
};

struct DiagnoseOptions {
  CalibrateOptions calibrate;  // repeatability, outliers, cancel
  std::uint64_t seed = 1;
  int mostRows = 2000;  // residuals that are asked: of a longer session stretches of neighbours
  std::function<void(const std::string& stage, double share)> progress;
  std::function<bool()> cancelled;
};

/// The loop's middle: which physical effect is missing from the model.
/// @param start values of the model's parameters to begin with. @param session must outlive the result.
/// @throw InputError as `calibrate`. A model that cannot be fitted gives the verdict insufficient_data.
Diagnosis diagnose(const Session& session, const Model& model, const DiagnoseOptions& options,
                   const Eigen::VectorXd& start = {});

/// Where the model fails, for a calibration already fitted.
std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted);

}  // namespace mm
