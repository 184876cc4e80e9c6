#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "import/import_faults.h"
#include "import/table_layout.h"
#include "session/text_file.h"

namespace mm {

/// What a column should be called in the mapping, and what the sentence that says so ends with.
struct ColumnRemedy {
  std::size_t column;
  std::string as, after;
};

/// Says what is not understood of the columns of a table, each with the line for the mapping that helps.
class ColumnFaults {
 public:
  ColumnFaults(const TextFile& file, const TableLayout& layout, ImportFaults& faults);

  /// "file:line: " of the names.
  std::string place() const;
  /// A column for messages: its name in quotes, or its number.
  std::string called(std::size_t column) const;
  /// Name of a column, or its number where it has none of its own that can be shown whole.
  std::string keyName(std::size_t column) const;
  /// The same as a key of the mapping, in quotes where YAML wants them.
  std::string key(std::size_t column) const;
  /// "add to the mapping (--columns): columns: {key: as}".
  std::string line(std::size_t column, const std::string& as) const;
  /// Whether a key of the mapping means this column: by its name in any case, or by its number.
  bool mapped(std::size_t column, const std::string& key) const;
  void add(const std::string& fault) { told_.push_back({fault, {}}); }
  /// @param what before "; " and the line() of the remedy; where several columns need one, the last fault has
  /// all of them in one line, as a file holds the key once.
  void add(const std::string& what, const ColumnRemedy& remedy);
  /// @param what follows "file:line: column 'name' ".
  void add(std::size_t column, const std::string& what);
  void add(std::size_t column, const std::string& what, const std::string& as, const std::string& after = "");
  /// Further lines of the mapping that a fault asks for.
  ImportFaults& lines() { return faults_; }
  bool empty() const { return faults_.empty() && told_.empty(); }
  /// Hands on what was added: the end.
  void tell();

 private:
  struct Told {
    std::string fault;
    std::optional<ColumnRemedy> remedy;
  };
  bool twice(std::size_t column) const;
  const TextFile& file_;
  const TableLayout& layout_;
  ImportFaults& faults_;
  std::map<std::string, std::size_t> counts_;  // of each name
  std::vector<Told> told_;
};

}  // namespace mm
