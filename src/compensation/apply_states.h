#pragma once
#include <filesystem>
#include <ostream>
#include <string>

#include "compensation/compensator.h"
#include "session/progress.h"

namespace mm {

/// What became of the rows of a CSV of states.
struct AppliedStates {
  std::size_t rows = 0, valid = 0;
  std::size_t untimed = 0;   // rows beyond the calibrated duration: effects of time not applied
  std::string firstReason;   // why a row is not valid, with its line; empty: all are
  std::string firstNote;     // of a row that is valid
  double largestMove = 0.0;  // m, of the valid rows
  double largestSigma = 0.0;
};

/// Columns that `applyStates` adds.
inline constexpr const char* kAppliedColumns = "corrected_x_mm,corrected_y_mm,corrected_z_mm,sigma_um,valid";

/// Corrects every row of a CSV in the import format and writes it with kAppliedColumns behind its own text,
/// in the order of the file. The corrected position is that of the probe tip's centre, or of a laser's
/// surface point, in `workpiece`; it is empty where it is not known, and `valid` (1 or 0) says whether it may
/// be used. Time counts on the clock of the calibrated session; temperatures and covariates come from the
/// row, else from its neighbours in time; the direction of travel from the velocities, at standstill from the
/// last motion; what a lag remembers from the rows of the file. @throw InputError naming file, line and
/// column.
AppliedStates applyStates(const std::filesystem::path& csv, const Calibration& calibration,
                          const Compensator& compensator, std::string& out,
                          const ProgressCallback& progress = {});

}  // namespace mm
