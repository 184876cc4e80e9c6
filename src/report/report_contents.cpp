#include "report/report_contents.h"

#include <cmath>

#include "base/error.h"
#include "base/utc_now.h"
#include "diagnosis/wording.h"
#include "model/model_spec.h"
#include "workflow/learning.h"

namespace mm {
namespace {

/// A fit beside the diagnosis; one that cannot be made is left out of the page.
std::optional<CalibrationResult> fitOf(const Session& session, const Calibration& calibration,
                                       const std::vector<EffectSpec>& effects,
                                       const CalibrateOptions& options) {
  try {
    Model model = modelFor(session, effects);
    const Eigen::VectorXd start = startFrom(calibration, model);
    CalibrationResult result = calibrate(session, std::move(model), options, start);
    if (result.cancelled) throw Cancelled("report cancelled");
    return result;
  } catch (const NumericalError&) {
    return std::nullopt;
  }
}

/// Held-out RMS of a fit, m (rad); NaN where there is none.
double heldOutOf(const std::optional<CalibrationResult>& fit, bool angular) {
  if (!fit) return kNotMeasured;
  return angular ? fit->figures.heldOutRmsAngular : fit->figures.heldOutRms;
}

/// One definition of "held out" on the whole page, that of the ledger: values fitted again without the block
/// of time that is judged, no drift predicted. It is what a corrected machine has, since no correction knows
/// the drift of the day; the diagnosis's own figures predict drift from its neighbours.
void holdOutAsTheLedger(ReportContents& report, const Session& session, const CalibrateOptions& fit) {
  Diagnosis& d = report.diagnosis;
  const double before = d.angular ? d.base.figures.heldOutRmsAngular : d.base.figures.heldOutRms;
  std::vector<EffectSpec> effects = report.calibration.effects;
  const auto with = [&](const EffectSpec& effect) {
    std::vector<EffectSpec> more = effects;
    more.push_back(effect);
    return heldOutOf(fitOf(session, report.calibration, more, fit), d.angular);
  };
  // one at a time, each with nothing else: those that the diagnosis worked out
  for (CandidateResult& c : d.candidates) {
    const bool worked = c.heldOutAfter != c.heldOutBefore;
    c.heldOutBefore = before;
    c.heldOutAfter = worked ? with(c.effect) : kNotMeasured;
  }
  std::vector<double> formulaOf;  // a formula: the figure that tells of which profile it speaks
  for (const FormulaResult& f : d.formulas) formulaOf.push_back(f.heldOutBefore);
  double now = before;
  const auto step = [&](const EffectSpec& effect, double& stepBefore, double& stepAfter) {
    stepBefore = now;
    const bool last = report.improved && effect == report.added.back();
    now = stepAfter = last ? heldOutOf(report.improved, d.angular) : with(effect);
    effects.push_back(effect);
  };
  for (CandidateResult& c : d.missing) step(c.effect, c.heldOutBefore, c.heldOutAfter);
  for (ProfileResult& p : d.profiles) {
    const double old = p.heldOutBefore;
    step(p.effect, p.heldOutBefore, p.heldOutAfter);
    for (std::size_t k = 0; k < d.formulas.size(); ++k) {
      if (formulaOf[k] != old) continue;
      std::vector<EffectSpec> all = report.calibration.effects;  // with the formula in the profile's place
      for (const EffectSpec& added : report.added)
        all.push_back(added == p.effect ? d.formulas[k].effect : added);
      d.formulas[k].heldOutBefore = p.heldOutBefore;
      d.formulas[k].heldOutAfter = heldOutOf(fitOf(session, report.calibration, all, fit), d.angular);
    }
  }
  d.heldOutBefore = before;
  d.heldOut = heldOutOf(report.improved, d.angular);
  if (std::isfinite(d.heldOut)) d.sentence = sentenceOf(d);
}

void addFits(ReportContents& report, const Session& session, const ReportOptions& options) {
  const CalibrationResult& base = report.diagnosis.base;
  CalibrateOptions fit = options.diagnose.calibrate;
  fit.method = Method::kLeastSquares;
  fit.progress = {};
  if (base.repeatabilityFrom != "estimated") fit.repeatability = base.repeatability;
  CalibrateOptions sameRows = fit;
  sameRows.rejectOutliers = false;
  sameRows.weights = base.weight;
  report.nominal = fitOf(session, report.calibration, {}, sameRows);
  try {
    report.held = compareCalibration(session, report.calibration, options.diagnose.calibrate);
  } catch (const Error&) {
    report.held.reset();  // e.g. a sensor of the calibration that this session does not have
  }
  for (const CandidateResult& c : report.diagnosis.missing) report.added.push_back(c.effect);
  for (const ProfileResult& p : report.diagnosis.profiles) report.added.push_back(p.effect);
  if (report.added.empty() && !report.diagnosis.formulas.empty())
    report.added.push_back(report.diagnosis.formulas.front().effect);
  if (!report.added.empty()) {
    std::vector<EffectSpec> effects = report.calibration.effects;
    effects.insert(effects.end(), report.added.begin(), report.added.end());
    report.improved = fitOf(session, report.calibration, effects, fit);
  }
  holdOutAsTheLedger(report, session, fit);
}

}  // namespace

ReportContents makeReport(const Session& session, const Calibration& calibration,
                          const ReportOptions& options) {
  ReportContents report;
  report.session = &session;
  report.sessionPath = options.sessionPath;
  report.calibrationPath = options.calibrationPath;
  report.created = options.created.empty() ? utcNow() : options.created;
  report.serial = options.serial;
  report.operatorName = options.operatorName;
  report.calibration = calibration;
  report.curves = options.curves;
  report.diagnosis = diagnoseCalibration(session, calibration, options.diagnose);
  ModelSpec model;
  model.machine = calibration.machineName;
  model.effects = calibration.effects;
  report.pointSet = checkPointSet(session, &model);
  if (!report.diagnosis.base.problem) return report;
  addFits(report, session, options);
  const CalibrationResult& base = report.diagnosis.base;
  report.variables =
      residualsByVariable(base, report.improved ? &*report.improved : nullptr, report.diagnosis.where);
  std::vector<NamedFit> fits = {{"this calibration", &base}};
  if (report.nominal) fits.push_back({"nominal machine", &*report.nominal});
  if (report.improved) fits.push_back({"with the named effects", &*report.improved});
  report.vectors = residualVectors(fits);
  report.positioning = axisPositioning(base);
  report.circles = circleTests(base);
  report.features = foundFeatures(base);
  report.thermal = thermalTest(base);
  return report;
}

}  // namespace mm
