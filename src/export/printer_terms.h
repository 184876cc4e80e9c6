#pragma once
#include <string>
#include <utility>
#include <vector>

#include "export/export_target.h"
#include "export/fitted_tables.h"

namespace mm {

/// What a note says wherever an angle between axes is exported.
extern const char* const kSquarenessNote;

/// By how much `output` is moved a metre of `input` so that the two axes are square, m/m, axes by their
/// letters; 0 where the machine has not both. Positive is added.
double squareness(const NeededCorrection& needed, const StraightPart& part, const char* output,
                  const char* input);

/// The whole reversal of each linear axis of `letters` that the machine has, m. One that is negative (the
/// slide leads its drive) is 0 and told in a note, for no firmware holds it; one below `least` (m) is 0.
/// @param title of the firmware.
std::vector<std::pair<const ExportAxis*, double>> reversals(const NeededCorrection& needed,
                                                            const StraightPart& part,
                                                            const std::string& letters, double least,
                                                            const std::string& title, Exported& out);

}  // namespace mm
