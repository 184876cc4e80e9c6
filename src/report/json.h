#pragma once
#include <string>
#include <vector>

#include "calibration_file/calibration.h"
#include "diagnosis/diagnose.h"
#include "estimation/calibrate.h"
#include "session/sense_checks.h"

namespace mm {

// What `mm … --json` prints and what the services answer in `json`: one object, in
// the units of people. A figure that does not exist is null; never NaN or Inf.

/// @param questions that the session raises (sensibleDoubts).
std::string calibrateJson(const CalibrationResult& result, const std::vector<Doubt>& questions = {});
/// @param where the model fails, most first.
std::string compareJson(const CalibrationResult& compared, const std::vector<WhereItFails>& where);
/// Of `add` and `remove`: the same as calibrateJson, and the ledger.
std::string changeJson(const CalibrationResult& result, const std::vector<LedgerEntry>& ledger);
std::string diagnoseJson(const Diagnosis& diagnosis);

}  // namespace mm
