#pragma once
#include <utility>
#include <vector>

#include "import/column_faults.h"
#include "import/import_format.h"

namespace mm {

/// Readings of joints without a column, as the mapping says them: joint and m or rad.
std::vector<std::pair<int, double>> fixedReadings(const ImportContext& context, ColumnFaults& faults);

/// What the columns of a table are together: something must have been measured, at a reading of a joint, and
/// what is there twice must agree. Fills what no column says; what is missing goes to `faults`.
void completeTable(const ImportContext& context, const TableLayout& layout,
                   const std::vector<ColumnSample>& samples, TableForm& form, ColumnFaults& faults);

}  // namespace mm
