#pragma once
#include <string>

#include "import/column_words.h"
#include "import/table_layout.h"
#include "import/unit.h"
#include "machine/machine.h"
#include "session/contacts_csv.h"

namespace mm {

/// One column of a file as it was understood, for people.
struct UnderstoodColumn {
  std::string name;     // in the file
  std::string meaning;  // "reading of joint x", "temperature bed", "left out: row number"
  std::string unit;     // of the file; empty: none
  double lower = kNotMeasured,
         upper = kNotMeasured;  // of its numbers, in the unit of the file; NaN: it has none
  std::string first;            // first value, as written
  std::string from;   // where the unit is known from: "header", "units line", "line 2", "mapping", "range"
  std::string key{};  // by which a mapping names it; empty: none may
};

struct ImportContext;

/// Understands the columns of a table: by the mapping, then by their names and units, by remarks in the file,
/// by what the machine can reach. Fills the context's columns and notes; what cannot be known is a fault,
/// each with the line for the mapping.
TableForm understandTable(const ImportContext& context, const TableLayout& layout);

}  // namespace mm
