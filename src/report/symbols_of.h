#pragma once
#include "calibration_file/calibration.h"
#include "diagnosis/diagnose.h"
#include "effects/iso230_symbol.h"
#include "estimation/calibrate.h"

namespace mm {

// Symbols of ISO 230-1 for the errors of the machine that a result is about.

/// @throw InputError: its URDF cannot be read.
inline ErrorSymbols symbolsOf(const Calibration& c) {
  return c.urdf.empty() ? ErrorSymbols() : ErrorSymbols(Machine(c.urdf, c.machineName));
}
/// None where nothing was fitted.
inline ErrorSymbols symbolsOf(const CalibrationResult& r) {
  return r.problem == nullptr ? ErrorSymbols() : ErrorSymbols(r.problem->model().machine());
}
/// Of the model that was diagnosed.
inline ErrorSymbols symbolsOf(const Diagnosis& d) { return symbolsOf(d.base); }

}  // namespace mm
