#pragma once
#include "import/column_faults.h"
#include "import/column_meaning.h"
#include "import/table_layout.h"
#include "import/text_file.h"

namespace mm {

/// What the columns of a table are together: something must have been measured, at a reading of a joint, and
/// what is there twice must agree. Fills what no column says; what is missing goes to `faults`.
void completeTable(const TextFile& file, const TableLayout& layout, const Machine& machine,
                   const Artifact* artifact, UnderstoodTable& table, ColumnFaults& faults);

}  // namespace mm
