#pragma once
#include "import/import_format.h"

namespace mm {

/// R-test and five-axis pivots: the rotary axes turn about a ball, and where it seems to go is read, dx, dy
/// and dz in the frame `workpiece`.
bool isRTest(const TextFile& file);
void readRTest(ImportContext& context);

}  // namespace mm
