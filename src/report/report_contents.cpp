#include "report/report_contents.h"

#include "base/error.h"
#include "base/utc_now.h"
#include "model/model_spec.h"
#include "workflow/learning.h"

namespace mm {
namespace {

void addFits(ReportContents& report, const Session& session, const ReportOptions& options) {
  const CalibrationResult& base = report.diagnosis.base;
  CalibrateOptions fit = options.diagnose.calibrate;
  fit.method = Method::kLeastSquares;
  fit.progress = {};
  if (base.repeatabilityFrom != "estimated") fit.repeatability = base.repeatability;
  CalibrateOptions sameRows = fit;
  sameRows.rejectOutliers = false;
  sameRows.weights = base.weight;
  report.nominal = fitWith(session, report.calibration, {}, sameRows);
  try {
    report.held = compareCalibration(session, report.calibration, options.diagnose.calibrate);
  } catch (const Error&) {
    report.held.reset();  // e.g. a sensor of the calibration that this session does not have
  }
  report.added = effectsFound(report.diagnosis);
  if (!report.added.empty()) {
    std::vector<EffectSpec> effects = report.calibration.effects;
    effects.insert(effects.end(), report.added.begin(), report.added.end());
    report.improved = fitWith(session, report.calibration, effects, fit);
  }
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
  report.profiles = addedProfiles(base);
  report.features = foundFeatures(base);
  report.thermal = thermalTest(base);
  return report;
}

}  // namespace mm
