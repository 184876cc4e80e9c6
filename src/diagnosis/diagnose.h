#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "effects/effect.h"
#include "estimation/calibrate.h"

namespace mm {

/// A share of the residual's variance that one variable explains, in any direction.
struct WhereItFails {
  std::string variable;  // "x", "x travel direction", "temperature bed", "time", "ball", …
  double share = 0.0;    // of the residual variance, adjusted for the number of terms; 0 … 1
  double pValue = 1.0;   // corrected for the number of variables asked
};

/// One estimated parameter of a missing effect, in its unit for people.
struct NamedValue {
  std::string name, unit;
  double value = 0.0, std = 0.0;
};

/// An effect that the data cannot tell from another one.
struct Confusable {
  EffectSpec effect;
  double delta = 0.0;  // difference of the penalised log-likelihoods after refit; at most 3
};

/// One effect of the catalogue, judged on the session.
struct CandidateResult {
  EffectSpec effect;
  std::vector<NamedValue> parameters;
  double pValue = 1.0;     // corrected for everything tried
  double stability = 0.0;  // share of resampled blocks in which it is still the choice
  double heldOutBefore = 0.0, heldOutAfter = 0.0;  // RMS, m (rad for angular sessions)
  double size = 0.0;  // RMS of its contribution after refit, m (rad for angular sessions)
  std::vector<Confusable> confusableWith;
  std::string cause, remedy;
};

/// A formula that explains what no effect of the catalogue does.
struct FormulaResult {
  EffectSpec effect;                               // type formula: ready to be added
  double heldOutBefore = 0.0, heldOutAfter = 0.0;  // m (rad)
};

struct CannotShow {
  EffectSpec effect;
  std::string why, moves;
};

/// A target for the measurement plan: values by the names of the import columns.
struct Move {
  std::vector<std::pair<std::string, double>> values;      // "x_mm", "b_deg", "wait_s" …
  std::vector<std::pair<std::string, std::string>> words;  // "feature"
  std::vector<double> approach;                            // unit vector in workpiece, or empty
  std::vector<std::pair<std::string, double>> from;        // a joint: the side it comes from, -1 or +1
};

enum class Verdict { kInsufficientData, kUnknownEffect, kConfusable, kMissingEffect, kExplained };
std::string nameOf(Verdict verdict);

struct Diagnosis {
  CalibrationResult base;  // the model as it is, refitted to the session
  Verdict verdict = Verdict::kExplained;
  std::string sentence;  // the verdict in words
  std::vector<WhereItFails> where;
  std::vector<CandidateResult> missing;     // accepted, in the order found
  std::vector<CandidateResult> candidates;  // every effect tried, best first
  std::vector<FormulaResult> formulas;
  bool formulaFirst = false;  // the first formula explains more than any effect of `missing`
  std::vector<CannotShow> cannotShow;
  std::vector<Move> nextMeasurement;
  bool angular = false;  // RMS figures are rad
  /// What is left depends on the same variables as `missing`: those effects have another shape here than in
  /// the catalogue.
  bool shapeLeft = false;
};

struct DiagnoseOptions {
  CalibrateOptions calibrate;  // repeatability, outliers, cancel
  std::uint64_t seed = 1;
  std::function<void(const std::string& stage, double share)> progress;
  std::function<bool()> cancelled;
};

/// The loop's middle: which physical effect is missing from the model (DESIGN section 6).
/// @param start values of the model's parameters to begin with. @param session must outlive the result.
/// @throw InputError as `calibrate`. A model that cannot be fitted gives the verdict insufficient_data.
Diagnosis diagnose(const Session& session, const Model& model, const DiagnoseOptions& options,
                   const Eigen::VectorXd& start = {});

/// Where the model fails, for a calibration already fitted.
std::vector<WhereItFails> whereItFails(const CalibrationResult& fitted);

}  // namespace mm
