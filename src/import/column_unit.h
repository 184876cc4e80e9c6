#pragma once
#include <optional>
#include <string>

#include "import/column_faults.h"
#include "import/meaning.h"
#include "import/table_layout.h"
#include "import/table_remarks.h"

namespace mm {

/// Where only one unit is possible: a machine's joint can go so far and no farther, and is not measured
/// within a fiftieth of its travel; a workshop has 5 to 45 degC, or a kelvin scale begins above 200.
std::optional<Unit> unitByRange(const ColumnSample& sample, const Meaning& meaning, const Machine& machine);

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

/// How the times of a column are counted.
struct TimeUnit {
  Unit unit;
  bool since1970 = false;
};
/// Of a column of numbers: by the unit that is said (empty: none), else by its range where the numbers count
/// from 1970. Nothing where the text is no unit of time, or where there is none and the range does not tell.
std::optional<TimeUnit> timeUnit(const ColumnSample& sample, const std::string& said);

}  // namespace mm
