#include "workflow/learning.h"

#include <algorithm>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "calibration_file/calibration_yaml.h"
#include "diagnosis/verdict.h"

namespace mm {

const EffectSpec* nextToAdd(const Diagnosis& d) {
  for (const CandidateResult& m : d.missing)
    if (!hasRivals(m)) return &m.effect;
  if (!d.missing.empty()) return &d.missing.front().effect;
  if (!d.profiles.empty()) return &d.profiles.front().effect;
  if (!d.formulas.empty()) return &d.formulas.front().effect;
  for (const Variation& v : d.variations) {
    if (!v.instead.empty() && (v.formula.type.empty() || v.instead.front().probability > 0.5))
      return &v.instead.front().effect;
    if (!v.formula.type.empty()) return &v.formula;
  }
  return nullptr;
}

CalibrateOptions calibratingIn(Job& job, unsigned threads) {
  CalibrateOptions options;
  options.threads = threads;
  options.cancelled = [&job] { return job.cancelled(); };
  options.progress = [&job](const std::string& stage, double share) { job.tell(stage, share); };
  return options;
}

Comparison compareWith(const Session& session, const Calibration& calibration,
                       const CalibrateOptions& options,
                       const std::function<void(const CalibrationResult&)>& fitted) {
  Comparison done{compareCalibration(session, calibration, options), {}};
  if (done.fit.cancelled) throw Cancelled("stopped while comparing; the calibration is kept");
  if (fitted) fitted(done.fit);
  if (options.progress) options.progress("finding where it fails", 0.0);
  const CancelScope scope(options.cancelled);
  done.where = whereItFails(done.fit);
  return done;
}

DiagnoseOptions diagnosing(CalibrateOptions calibrate) {
  DiagnoseOptions options;
  options.seed = calibrate.seed;
  options.cancelled = calibrate.cancelled;
  options.progress = calibrate.progress;
  options.calibrate = std::move(calibrate);
  return options;
}

Diagnosis diagnoseCalibration(const Session& session, const Calibration& calibration,
                              DiagnoseOptions options) {
  checkMachine(calibration, session);
  options.calibrate = refitting(options.calibrate, calibration);
  const Model model = modelFor(session, calibration.effects);
  return diagnose(session, model, options, startFrom(calibration, model));
}

Learned learnAll(const Session& session, const Calibration& calibration, const DiagnoseOptions& options,
                 std::size_t most, const std::function<void(const Diagnosis&, Recalibration&)>& kept) {
  Learned learned;
  Calibration now = calibration;
  try {
    for (;;) {
      learned.diagnosis.reset();
      const Diagnosis& diagnosis = learned.diagnosis.emplace(diagnoseCalibration(session, now, options));
      learned.sentence = diagnosis.sentence;
      const EffectSpec* next = nextToAdd(diagnosis);
      // What is in the model already and is still named is no step forward: somebody has to look at it.
      learned.complete = next == nullptr && diagnosis.verdict != Verdict::kInsufficientData &&
                         diagnosis.verdict != Verdict::kQuestion;
      if (next == nullptr || learned.steps == most ||
          std::any_of(now.effects.begin(), now.effects.end(),
                      [&](const EffectSpec& e) { return sameEffect(e, *next, now.domain); }))
        return learned;
      Recalibration step = addEffect(session, now, *next, options.calibrate);
      if (step.result.cancelled) break;
      completeCalibration(step.calibration);  // the next line of the ledger names it
      kept(diagnosis, step);
      now = step.calibration;
      learned.last = std::move(step);
      ++learned.steps;
    }
  } catch (const Cancelled&) {
  }
  learned.stopped = true;
  return learned;
}

}  // namespace mm
