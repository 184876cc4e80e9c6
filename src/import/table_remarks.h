#pragma once
#include <cstddef>
#include <string>

#include "import/table_layout.h"
#include "machine/machine.h"

namespace mm {

/// A unit that a line of the file says of all columns of a kind.
struct RemarkedUnit {
  std::string text;
  std::size_t line = 0;  // 0: it is not said
};

/// What the lines around a table say in words: `all lengths in mm`, `Axis: X`.
struct TableRemarks {
  RemarkedUnit length, angle;
  int axis = -1;             // joint, -1: it is not said
  std::size_t axisLine = 0;  // where a heading names one in passing, "Interferometer, axis X"; else 0
};

TableRemarks tableRemarks(const TableLayout& layout, const Machine& machine);  ///< for people

}  // namespace mm
