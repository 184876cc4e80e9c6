#pragma once
#include "import/import_format.h"

namespace mm {

/// ISO 10360-2: faces of a step gauge, or length bars, along one linear joint: calibrated and indicated
/// lengths.
bool isGaugeLengths(const TextFile& file);
void readGaugeLengths(ImportContext& context);

}  // namespace mm
