#pragma once
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "import/import_format.h"
#include "import/meaning.h"
#include "import/table_layout.h"

namespace mm {

/// A table with a head of `key: value` lines, as instruments export it: what formats of their own read.
class RecordTable {
 public:
  /// @throw InputError when no table is seen.
  explicit RecordTable(ImportContext& context);

  struct Row {
    std::size_t line = 0;
    std::vector<std::string> cells;
  };
  const std::vector<Row>& rows() const { return rows_; }  ///< in file order
  const TableLayout& layout() const { return layout_; }   ///< of the file
  /// First column with one of these words in its name, or -1.
  int column(const std::vector<std::string>& words) const;
  /// Value of the first of these keys in the head of the file (in small letters), or of the mapping, or
  /// empty.
  std::string said(const std::vector<std::string>& keys, const std::string& mapped) const;
  /// The same as a number in SI; a unit may stand in the key or behind the number. False when it is not said;
  /// a fault when it is no number. @param unit of a number without one.
  bool number(const std::vector<std::string>& keys, const std::string& mapped, UnitKind kind,
              const std::string& unit, double& value);
  /// A cell in SI, by the unit of its column (`fallback` where it has none; empty: a fault). NaN when empty,
  /// and after a fault.
  double value(const Row& row, int column, UnitKind kind, const std::string& fallback);
  std::string text(const Row& row, int column) const;
  /// Joint that is said, -1 and a fault when it is none of the machine's.
  int joint(const std::string& name, const std::string& key);
  /// Enters a column in the table that is shown.
  void show(int column, const std::string& meaning, const std::string& unit);
  /// "key: value" lines between the rows, by line.
  const std::map<std::size_t, std::pair<std::string, std::string>>& between() const { return between_; }

 private:
  ImportContext& context_;
  TableLayout layout_;
  std::vector<Row> rows_;
  std::vector<std::pair<std::string, std::string>> head_;
  std::map<std::size_t, std::pair<std::string, std::string>> between_;
};

/// Whether one of the first lines has one of these words (small letters).
bool headHas(const TextFile& file, const std::vector<std::string>& words, std::size_t lines = 15);

/// Index of a setup, made when it is new.
int setupIndex(Session& session, const std::string& name);

/// A row of this machine with nothing measured yet: joints at the mapping's `fixed` or 0.
Observation blankRow(const ImportContext& context, ObservationKind kind, std::size_t line, double time);

}  // namespace mm
