#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "export/export_target.h"
#include "export/fitted_tables.h"

namespace mm {

/// Angles and reversals, which are all that printers and grblHAL have: of each axis for which the calibration
/// has something what was active and what is added; nothing of the others.
struct PrinterTerms {
  std::optional<double> xy, xz, yz;  // tangents: how much of the second axis is added to the first
  std::vector<std::pair<const ExportAxis*, double>> reversals;  // m, not negative
  StraightPart adds, active;
};

/// What a target has a place for.
struct PrinterPlaces {
  std::string title;           // for people
  std::string reversals;       // letters of axes
  double leastReversal = 0.0;  // m: no more is nothing
  bool angles = true;
  bool sharedFraction = false;  // the reversals of all axes are scaled by one number: all are written or none
};

/// Fills `out.axes`, and a note where a reversal cannot be held.
PrinterTerms printerTerms(const NeededCorrection& needed, const PrinterPlaces& places, Exported& out);

/// What the page says of it.
extern const char* const kSquarenessNote;

}  // namespace mm
