#pragma once
#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "import/column_mapping.h"
#include "import/decimal_mark.h"
#include "import/import_faults.h"
#include "session/csv_cells.h"
#include "session/text_file.h"

namespace mm {

/// How a table is written, seen from its lines.
struct TableLayout {
  char separator = ',';
  bool decimalComma = false;
  DecimalMarks marks;                                        // why, unless the mapping said it
  std::size_t headerLine = 0;                                // 0: none
  std::size_t unitsLine = 0;                                 // 0: none
  std::size_t firstRow = 0;                                  // 0: there is no row
  std::vector<std::string> names;                            // of the columns; "1", "2" … without a header
  std::vector<std::string> units;                            // of the units line, empty without
  std::vector<std::pair<std::size_t, std::string>> remarks;  // lines that are not of the table: number, text
  std::size_t lastHead() const {
    return firstRow > 0 ? firstRow - 1 : std::max(headerLine, unitsLine);
  }  ///< 0: none
  /// "separated by ';', decimal comma".
  std::string inWords() const;
};

inline constexpr std::size_t kMostColumns = 2000;
/// @throw InputError: the table has more columns than that. @param line that has them.
void refuseTooWide(const TextFile& file, std::size_t line, std::size_t columns);

/// Looks at separators, decimal mark, remarks, header and units line. What the mapping says is taken from it.
/// @throw InputError when the file holds no table.
TableLayout tableLayout(const TextFile& file, const ColumnMapping& mapping);

/// What was written in one column.
struct ColumnSample {
  std::size_t numbers = 0, texts = 0, calendars = 0, clocks = 0, count = 0;
  double lower = 0.0, upper = 0.0;  // of the numbers, as written
  std::string first;
  std::set<std::string> words;              // some of its different texts
  std::string suffix;                       // the unit behind each number, where all have the same: `12.5 mm`
  std::size_t slashed = 0;                  // calendars with slashes
  bool monthFirst = true, dayFirst = true;  // what all of these may be
  bool midnight = true;                     // all calendars without a time of day
};

using Cells = std::vector<std::string_view>;
/// Tells of each line from the first row on that is neither blank nor a remark: its number, itself, and its
/// cells (none: a quote is not closed).
void eachRow(const TextFile& file, const TableLayout& layout,
             const std::function<void(std::size_t number, std::string_view line, Cells& cells)>& tell);

std::vector<ColumnSample> columnSamples(const TextFile& file, const TableLayout& layout);  ///< as text

/// A fault: the decimal mark cannot be seen, with the line for the mapping.
void refuseUnclear(const TextFile& file, const TableLayout& layout, const UnclearNumber& number,
                   ImportFaults& faults);

/// A line without its mark of a remark (#, %, //), trimmed; false when it has none.
bool takeRemark(std::string_view line, std::string& text);

/// `key: value` or `key = value` of a remark or a line above the table, keys in small letters.
bool keyValue(std::string_view text, std::string& key, std::string& value);

}  // namespace mm
