#pragma once
#include "import/import_format.h"

namespace mm {

/// ISO 230-2: targets by runs, in one or both directions of approach; deviations or measured positions.
/// Either a line a target and a column a run (`1+`, `1-`, `Run 2 ↓`), or as the standard prints it, a column
/// a target.
bool isPositioningTable(const TextFile& file);
void readPositioningTable(ImportContext& context);

}  // namespace mm
