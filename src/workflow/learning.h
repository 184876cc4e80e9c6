#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "diagnosis/diagnose.h"
#include "workflow/job.h"
#include "workflow/recalibration.h"

namespace mm {

/// A fit that the job tells of and cancels; it keeps the best so far then.
CalibrateOptions calibratingIn(Job& job, unsigned threads);
/// A diagnosis whose fits are made like this; told of and cancelled as they are.
DiagnoseOptions diagnosing(CalibrateOptions calibrate);

/// A session beside a calibration, and where that fails.
struct Comparison {
  CalibrationResult fit;  // with the calibration's values held
  std::vector<WhereItFails> where;
};
/// @param fitted is told before it is asked where the calibration fails; may be empty. @throw Cancelled;
/// InputError: as compareCalibration.
Comparison compareWith(const Session& session, const Calibration& calibration,
                       const CalibrateOptions& options,
                       const std::function<void(const CalibrationResult&)>& fitted = {});

/// Which physical effect the calibration's model misses on a session: everything is refitted, from its
/// values. Its figures held out are those that the ledger will have: values fitted again without the block of
/// time that is judged, no drift predicted, as no correction knows the drift of the day.
Diagnosis diagnoseCalibration(const Session& session, const Calibration& calibration,
                              DiagnoseOptions options);

/// What a diagnosis would add to the model: effects and profiles, else a formula.
std::vector<EffectSpec> effectsFound(const Diagnosis& diagnosis);
/// These effects fitted to a session, from the calibration's values; empty: no fit can be made, or an input
/// is unknown in too many rows.
/// @throw Cancelled.
std::optional<CalibrationResult> fitWith(const Session& session, const Calibration& calibration,
                                         const std::vector<EffectSpec>& effects,
                                         const CalibrateOptions& options);

/// How far a search for what is missing has come.
struct Learned {
  std::optional<Recalibration> last;  // of the last step; empty: nothing was added
  std::size_t steps = 0;
  std::optional<Diagnosis> diagnosis;  // the last, of the model as it is now; empty: stopped before
  std::string sentence;                // the verdict of the last diagnosis, in words
  bool complete = false;               // the last diagnosis found nothing more to add
  bool stopped = false;                // asked to; what was added before is kept
};

/// The effect that a diagnosis says to add next: what is missing, first that which nothing else may act in
/// the place of, else a profile, else a formula, else what
/// follows an effect that is not the same everywhere; null: none.
const EffectSpec* nextToAdd(const Diagnosis& diagnosis);

/// Diagnoses, adds the effect that is named and refits, until nothing is missing. Each step is a line of the
/// ledger and can be taken back. @param most steps. @param kept is told of each step when it is done, with
/// the diagnosis that led to it: where a caller saves it. @throw as diagnoseCalibration and addEffect.
Learned learnAll(const Session& session, const Calibration& calibration, const DiagnoseOptions& options,
                 std::size_t most, const std::function<void(const Diagnosis&, Recalibration&)>& kept);

}  // namespace mm
