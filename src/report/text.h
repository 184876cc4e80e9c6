#pragma once
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"

namespace mm {

// What `mm` prints for people: plain text of at most 100 columns, units beside every number.

/// Parameters with their uncertainty, what the session does not determine, before and after, outliers by row.
std::string calibrateText(const CalibrationResult& result);
/// One line: how far from the repeatability the model is, and what to type next.
/// @param session, calibration paths; the calibration empty: it was not written.
std::string nextText(const CalibrationResult& result, const std::string& session,
                     const std::string& calibration);
/// In a line: RMS before (m, or rad of an angular session) and after, held out, and the repeatability.
std::string errorText(const CalibrationResult& result, double before);
/// In a line: RMS, and the noise that a diagnosis found in it; empty where no fit was made.
std::string errorText(const Diagnosis& diagnosis);
/// Size of the residuals, and where the model fails.
std::string compareText(const CalibrationResult& compared, const std::vector<WhereItFails>& where);
/// Verdict in a sentence, where it fails, what is missing with cause and remedy, and what to type next.
/// @param session, calibration paths for the `mm add` line.
std::string diagnoseText(const Diagnosis& diagnosis, const std::string& session,
                         const std::string& calibration);
/// Each step of the model, with the error as it fell. @param angular figures are in rad.
std::string ledgerText(const Calibration& calibration, bool angular);
/// The best RMS of each generation as CSV: `generation,rms_um` (or `rms_arcsec`).
std::string curveCsv(const GeneticSummary& genetic, bool angular);

}  // namespace mm
