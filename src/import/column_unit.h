#pragma once
#include <optional>
#include <string>
#include <vector>

#include "import/column_faults.h"
#include "import/column_mapping.h"
#include "import/meaning.h"
#include "import/table_layout.h"
#include "import/table_remarks.h"
#include "session/csv_columns.h"

namespace mm {

/// A column of a table, and what the table says beside it.
struct ColumnPlace {
  std::size_t column;
  const ColumnSample& sample;
  const TableLayout& layout;
  const TableRemarks& remarks;
  const Machine& machine;
};
/// A unit that stands in a name; empty: none does.
struct NamedUnit {
  std::string text, from;  // from: "header", "mapping"
};
/// The unit of a column: of its name, of the units line, of the remarks, or the only one that is possible.
/// Nothing, and a fault, where there is none or it is of another kind. @param from gets where it is known
/// from.
std::optional<Unit> unitOfColumn(const ColumnPlace& place, const Meaning& meaning, const NamedUnit& named,
                                 ColumnFaults& faults, std::string& from);

/// Whether readings are within a joint's travel, and fill a part of it. @param factor to SI.
bool fitsTravel(const ColumnSample& sample, double factor, const Joint& joint);

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
