#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "import/column_mapping.h"
#include "import/table_layout.h"
#include "session/input_faults.h"
#include "session/text_file.h"

namespace mm {

/// Says what is not understood of the columns of a table, each with the line for the mapping that helps.
class ColumnFaults {
 public:
  ColumnFaults(const TextFile& file, const TableLayout& layout, FaultList& faults)
      : file_(file), layout_(layout), faults_(faults) {}

  /// "file:line: " of the names.
  std::string place() const;
  /// A column for messages: its name in quotes, or its number.
  std::string called(std::size_t column) const;
  /// Name of a column, or its number where it has none of its own.
  std::string keyName(std::size_t column) const;
  /// The same as a key of the mapping, in quotes where YAML wants them.
  std::string key(std::size_t column) const;
  /// "add to the mapping (--columns): columns: {key: as}"; where several columns need one, the last fault
  /// has all of them in one line, as a file holds the key once.
  std::string remedy(std::size_t column, const std::string& as) const;
  /// Whether a key of the mapping means this column: by its name in any case, or by its number.
  bool mapped(std::size_t column, const std::string& key) const;
  void add(const std::string& fault) { told_.push_back(fault); }
  /// @param what follows "file:line: column 'name' ".
  void add(std::size_t column, const std::string& what);
  bool empty() const { return faults_.empty() && told_.empty(); }
  /// Hands on what was added: the end.
  void tell();

 private:
  bool twice(std::size_t column) const;
  const TextFile& file_;
  const TableLayout& layout_;
  FaultList& faults_;
  std::vector<std::string> told_;
};

}  // namespace mm
