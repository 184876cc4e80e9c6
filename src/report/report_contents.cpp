#include "report/report_contents.h"

#include "base/error.h"
#include "base/utc_now.h"
#include "model/model_spec.h"
#include "workflow/recalibration.h"

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
  if (report.added.empty()) return;
  std::vector<EffectSpec> effects = report.calibration.effects;
  effects.insert(effects.end(), report.added.begin(), report.added.end());
  report.improved = fitOf(session, report.calibration, effects, fit);
}

}  // namespace

ReportContents makeReport(const Session& session, const Calibration& calibration,
                          const ReportOptions& options) {
  ReportContents report;
  report.session = &session;
  report.sessionPath = options.sessionPath;
  report.calibrationPath = options.calibrationPath;
  report.created = options.created.empty() ? utcNow() : options.created;
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
  report.thermal = thermalTest(base);
  return report;
}

}  // namespace mm
