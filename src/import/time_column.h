#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "import/column_faults.h"
#include "import/column_mapping.h"
#include "import/table_layout.h"
#include "session/csv_columns.h"

namespace mm {

/// How the times of a column are written, as it was understood.
struct TimeColumn {
  TimeForm form = TimeForm::kNumber;
  double factor = 1.0;     // s a number
  bool since1970 = false;  // else from a zero of its own
  std::string unit, from;  // for people: "s", "calendar, month first"; where it is known from
  std::vector<std::string> notes;
};

/// Looks at stamps, clocks, or numbers by their unit and range; what cannot be known goes to `faults`.
/// @param said unit in the column's name, empty without.
TimeColumn timeColumn(std::size_t column, const ColumnSample& sample, const TableLayout& layout,
                      const ColumnMapping& mapping, const std::string& said, ColumnFaults& faults);

}  // namespace mm
