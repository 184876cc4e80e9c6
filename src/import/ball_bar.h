#pragma once
#include "import/import_format.h"

namespace mm {

/// ISO 230-4: circles of a ball bar, angle (or time) and radius (or its deviation).
bool isBallBar(const TextFile& file);
void readBallBar(ImportContext& context);

}  // namespace mm
