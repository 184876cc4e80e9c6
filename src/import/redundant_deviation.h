#pragma once
#include "import/column_faults.h"
#include "import/column_meaning.h"
#include "import/table_layout.h"
#include "session/text_file.h"

namespace mm {

/// A table may give target, measured position and deviation of one joint: the deviation is measured minus
/// target, or the opposite. The finer of the two is kept, the other set aside with the reason; where they
/// disagree by more than they are written to, that is a fault.
void settleRedundant(const TextFile& file, const TableLayout& layout, UnderstoodTable& table,
                     const Machine& machine, ColumnFaults& faults);

}  // namespace mm
