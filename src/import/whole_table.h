#pragma once
#include <vector>

#include "import/column_faults.h"
#include "import/import_format.h"

namespace mm {

/// What the columns of a table are together: something must have been measured, at a reading of a joint, and
/// what is there twice must agree. Fills what no column says; what is missing goes to `faults`.
void completeTable(const ImportContext& context, const TableLayout& layout,
                   const std::vector<ColumnSample>& samples, TableForm& form, ColumnFaults& faults);

}  // namespace mm
