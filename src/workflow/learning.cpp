#include "workflow/learning.h"

#include <algorithm>
#include <cmath>

#include "base/cancel_scope.h"
#include "base/error.h"
#include "calibration_file/calibration_yaml.h"
#include "diagnosis/verdict.h"
#include "diagnosis/wording.h"

namespace mm {
namespace {

/// Held-out RMS of a fit, m (rad); NaN where there is none.
double heldOutOf(const std::optional<CalibrationResult>& fit, bool angular) {
  if (!fit) return kNotMeasured;
  return angular ? fit->figures.heldOutRmsAngular : fit->figures.heldOutRms;
}

/// Puts the figures of the ledger in the place of the diagnosis's own, which predict drift from its
/// neighbours.
void holdOutAsTheLedger(Diagnosis& d, const Session& session, const Calibration& calibration,
                        CalibrateOptions fit) {
  fit.progress = {};
  if (d.base.repeatabilityFrom != "estimated") fit.repeatability = d.base.repeatability;
  const double before = d.angular ? d.base.figures.heldOutRmsAngular : d.base.figures.heldOutRms;
  const std::vector<EffectSpec> found = effectsFound(d);
  std::vector<EffectSpec> effects = calibration.effects;
  const auto with = [&](const EffectSpec& effect) {
    std::vector<EffectSpec> more = effects;
    more.push_back(effect);
    return heldOutOf(fitWith(session, calibration, more, fit), d.angular);
  };
  // one at a time, each with nothing else: those that the diagnosis worked out
  for (CandidateResult& c : d.candidates) {
    const bool worked = c.heldOutAfter != c.heldOutBefore;
    c.heldOutBefore = before;
    c.heldOutAfter = worked ? with(c.effect) : kNotMeasured;
  }
  double now = before;
  const auto step = [&](const EffectSpec& effect, double& stepBefore, double& stepAfter) {
    stepBefore = now;
    now = stepAfter = with(effect);
    effects.push_back(effect);
  };
  for (CandidateResult& c : d.missing) step(c.effect, c.heldOutBefore, c.heldOutAfter);
  for (ProfileResult& p : d.profiles) {
    step(p.effect, p.heldOutBefore, p.heldOutAfter);
    for (FormulaResult& f : d.formulas) {
      if (!(f.profile == p.effect)) continue;
      std::vector<EffectSpec> all = calibration.effects;  // with the formula in the profile's place
      for (const EffectSpec& added : found) all.push_back(added == p.effect ? f.effect : added);
      f.heldOutBefore = p.heldOutBefore;
      f.heldOutAfter = heldOutOf(fitWith(session, calibration, all, fit), d.angular);
    }
  }
  if (d.missing.empty() && d.profiles.empty() && !found.empty()) now = with(found.front());
  d.heldOutBefore = before;
  d.heldOut = found.empty() ? kNotMeasured : now;
  if (std::isfinite(d.heldOut)) d.sentence = sentenceOf(d);
}

}  // namespace

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
  Diagnosis d = diagnose(session, model, options, startFrom(calibration, model));
  if (d.base.problem) holdOutAsTheLedger(d, session, calibration, options.calibrate);
  return d;
}

std::vector<EffectSpec> effectsFound(const Diagnosis& d) {
  std::vector<EffectSpec> found;
  for (const CandidateResult& c : d.missing) found.push_back(c.effect);
  for (const ProfileResult& p : d.profiles) found.push_back(p.effect);
  if (found.empty() && !d.formulas.empty()) found.push_back(d.formulas.front().effect);
  return found;
}

std::optional<CalibrationResult> fitWith(const Session& session, const Calibration& calibration,
                                         const std::vector<EffectSpec>& effects,
                                         const CalibrateOptions& options) {
  try {
    Model model = modelFor(session, effects);
    const Eigen::VectorXd start = startFrom(calibration, model);
    CalibrationResult result = calibrate(session, std::move(model), options, start);
    if (result.cancelled) throw Cancelled("stopped before the models were refitted; nothing was changed");
    return result;
  } catch (const NumericalError&) {
    return std::nullopt;
  } catch (const InputError&) {  // an input that a candidate needs is unknown in too many rows
    return std::nullopt;
  }
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
