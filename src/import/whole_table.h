#pragma once
#include <utility>
#include <vector>

#include "import/column_faults.h"
#include "import/column_meaning.h"
#include "import/table_layout.h"
#include "session/text_file.h"

namespace mm {

/// Readings of joints without a column, as the mapping says them: joint and m or rad.
std::vector<std::pair<int, double>> fixedReadings(const ColumnMapping& mapping, const Machine& machine,
                                                  ColumnFaults& faults);

/// What the columns of a table are together: something must have been measured, at a reading of a joint, and
/// what is there twice must agree. Fills what no column says; what is missing goes to `faults`.
void completeTable(const TextFile& file, const TableLayout& layout, const std::vector<ColumnSample>& samples,
                   const Machine& machine, const Artifact* artifact, UnderstoodTable& table,
                   ColumnFaults& faults);

}  // namespace mm
