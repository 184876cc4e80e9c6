#pragma once
#include <optional>
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "design/point_set.h"
#include "diagnosis/diagnose.h"
#include "report/found_features.h"
#include "report/iso_tests.h"
#include "report/report_curve.h"
#include "report/report_profiles.h"
#include "report/report_variables.h"
#include "report/report_vectors.h"
#include "uncertainty/diagonal_tests.h"
#include "uncertainty/length_tests.h"
#include "uncertainty/rotation_tests.h"
#include "uncertainty/standard_tests.h"

namespace mm {

/// Error motions of an axis of rotation as measured, and those that the model leaves.
struct RotationPair {
  RotationTest measured, left;
};

/// What a page says of itself, as whoever asks for it states it.
struct ReportHead {
  std::string sessionPath, calibrationPath;  // as typed; no calibration: the machine as it is
  std::string created;                       // ISO 8601, UTC; empty, of what is asked for: now
  std::string serial, operatorName;          // of the machine; who measured; empty: not told
  std::vector<ConvergenceCurve> curves;
};

/// Everything that the report's page shows. Refers to the session, which must outlive it.
struct ReportContents : ReportHead {
  const Session* session = nullptr;
  std::vector<FoundFeature> features;  // balls and points where the session has them
  Calibration calibration;
  Diagnosis diagnosis;                       // its base: the model refitted to this session
  std::optional<CalibrationResult> nominal;  // no effects
  std::optional<CalibrationResult>
      held;  // the calibration's values held, only the session's own unknowns fitted
  std::optional<CalibrationResult> improved;  // with what the diagnosis named added
  PointSet pointSet;
  std::vector<VariableView> variables;
  ResidualVectors vectors;
  std::vector<AxisPositioning> positioning;
  std::vector<CircleTest> circles;
  std::vector<AddedProfile> profiles;  // of the calibration's model, with what was measured
  ThermalReport thermal;
  std::vector<DiagonalTest> diagonals;
  std::vector<RotationPair> rotations;
  std::vector<LengthLineTest> lengths;
  std::vector<StandardTest> tests;  // in words, those of these that the rows alone tell

  bool calibrated() const { return !calibrationPath.empty(); }  ///< or of the machine as it is
};

struct ReportOptions : ReportHead {
  DiagnoseOptions diagnose;
};

/// Diagnoses the calibration on the session and collects what the page shows.
/// @throw InputError as `diagnoseCalibration`; Cancelled.
ReportContents makeReport(const Session& session, const Calibration& calibration,
                          const ReportOptions& options);

/// The tests of the standards on the machine as it is: the nominal model, no effect, nothing diagnosed. Every
/// measurement counts. @throw InputError as `calibrate`; NumericalError; Cancelled.
ReportContents makeReport(const Session& session, const ReportOptions& options);

/// What the page is called: the machine, when it was measured where that is known, and how warm it was.
std::string reportTitle(const ReportContents& report);

/// What the page says first: the verdict of the diagnosis, or that there is no calibration.
std::string reportSentence(const ReportContents& report);

/// The contents as one JSON object in the units of people; what does not exist is null.
std::string reportJson(const ReportContents& report);

}  // namespace mm
