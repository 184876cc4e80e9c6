#include "report/report_contents.h"

#include <algorithm>

#include "base/error.h"
#include "base/utc_now.h"
#include "model/model_spec.h"
#include "report/text_parts.h"
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
  const std::vector<EffectSpec> added = effectsFound(report.diagnosis);
  if (added.empty()) return;
  std::vector<EffectSpec> effects = report.calibration.effects;
  effects.insert(effects.end(), added.begin(), added.end());
  report.improved = fitWith(session, report.calibration, effects, fit);
}

/// What a page has of every session, with a calibration or without.
ReportContents begun(const Session& session, const ReportOptions& options) {
  ReportContents report;
  static_cast<ReportHead&>(report) = options;
  report.session = &session;
  if (report.created.empty()) report.created = utcNow();
  report.tests = standardTests(session);
  return report;
}

/// The tests of the standards and the residuals, of the fit that is the diagnosis' base.
void addTests(ReportContents& report) {
  const CalibrationResult& base = report.diagnosis.base;
  const Session& session = *report.session;
  const ResidualOf left = residualsOf(base);
  report.variables =
      residualsByVariable(base, report.improved ? &*report.improved : nullptr, report.diagnosis.where);
  report.positioning = axisPositioning(base);
  report.circles = circleTests(base);
  report.features = foundFeatures(base);
  report.thermal = thermalReport(base);
  report.diagonals = diagonalTests(session, left);
  report.lengths = lengthTests(session, left);
  const std::vector<RotationTest> remaining = rotationTests(session, left);
  for (RotationTest& test : rotationTests(session)) {
    const auto same = std::find_if(remaining.begin(), remaining.end(), [&](const RotationTest& r) {
      return r.joint == test.joint && r.setup == test.setup;
    });
    report.rotations.push_back({std::move(test), same != remaining.end() ? *same : RotationTest{}});
  }
}

}  // namespace

ReportContents makeReport(const Session& session, const Calibration& calibration,
                          const ReportOptions& options) {
  ReportContents report = begun(session, options);
  report.calibration = calibration;
  report.diagnosis = diagnoseCalibration(session, calibration, options.diagnose);
  ModelSpec model;
  model.machine = calibration.machineName;
  model.effects = calibration.effects;
  report.pointSet = checkPointSet(session, &model);
  if (!report.diagnosis.base.problem) return report;
  addFits(report, session, options);
  addTests(report);
  const CalibrationResult& base = report.diagnosis.base;
  std::vector<NamedFit> fits = {{"this calibration", &base}};
  if (report.nominal) fits.push_back({"nominal machine", &*report.nominal});
  if (report.improved) fits.push_back({"with the named effects", &*report.improved});
  report.vectors = residualVectors(fits);
  report.profiles = addedProfiles(base);
  return report;
}

ReportContents makeReport(const Session& session, const ReportOptions& options) {
  ReportContents report = begun(session, options);
  report.calibration.machineName = session.machine.name();
  CalibrateOptions fit = options.diagnose.calibrate;
  fit.method = Method::kLeastSquares;
  fit.rejectOutliers = false;
  report.diagnosis.base = calibrate(session, modelFor(session, {}), fit);
  const CalibrationResult& base = report.diagnosis.base;
  report.diagnosis.where = whereItFails(base);
  report.diagnosis.angular = angularOnly(base);
  report.pointSet = checkPointSet(session, nullptr);
  addTests(report);
  report.vectors = residualVectors({{"the machine as it is", &base}});
  return report;
}

}  // namespace mm
