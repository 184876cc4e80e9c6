#pragma once
#include "import/import_format.h"

namespace mm {

/// Anybody's table: one row a measurement, columns by name.
void readAnyTable(ImportContext& context);

}  // namespace mm
