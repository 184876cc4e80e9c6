#pragma once
#include <string>

#include "calibration_file/calibration.h"
#include "calibration_file/calibration_store.h"

namespace mm {

// What the page shows of calibrations, as JSON in the units of people; no figure is NaN.

/// Effects with their values ± uncertainty, figures and ledger. @param kept whether the store has it.
std::string calibrationDocument(const Calibration& calibration, bool kept);

/// All calibrations that are kept, as `mm history --json`, with what the page draws of each.
std::string historyDocument(const CalibrationStore& store);

/// The correction on a grid over the calibrated volume: displacement and its standard deviation, and what it
/// is valid for. Travel is taken upwards, rotary joints in the middle of what was calibrated.
/// @param calibration null: there is none. @param candidate the same.
std::string correctionDocument(const Calibration* active, const Calibration* candidate);

/// The catalogue of effects as the page offers it: type, example, what shows it.
std::string catalogueDocument();

}  // namespace mm
