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
  /// First column with one of these words (`angle phi winkel`) in its name, or -1.
  int column(std::string_view words) const;
  /// Value of the first of these keys in the head of the file (in small letters), or of the mapping, or
  /// empty.
  std::string said(const std::vector<std::string>& keys, const std::string& mapped) const {
    return find(keys, mapped).text;
  }
  /// The same as a number in SI; a unit may stand in the key or behind the number. False when it is not said;
  /// a fault when it is no number. @param unit of a number without one.
  bool number(const std::vector<std::string>& keys, const std::string& mapped, UnitKind kind,
              const std::string& unit, double& value);
  /// The same as a place in mm, put into the readings (m): of joints x, y and z where it has three values,
  /// else of as many `joints`. False, and a fault, when it is not said so. @param of what, in words.
  bool place(const std::vector<std::string>& keys, const std::string& mapped, const std::string& of,
             const std::vector<int>& joints, std::vector<double>& readings) const;
  /// A cell in SI, by the unit of its column; where that has none by `fallback`, or if that is empty, too,
  /// the mapping's `unit` of a length (without: a fault), deg, s. NaN when empty, and after a fault.
  double value(const Row& row, int column, UnitKind kind, std::string fallback = "");
  std::string text(const Row& row, int column) const;
  /// Joint that is said, -1 and a fault when it is none of the machine's.
  int joint(const std::string& name, const std::string& key);
  /// Enters a column in the table that is shown.
  void show(int column, const std::string& meaning, const std::string& unit);
  /// "key: value" lines between the rows, by line.
  const std::map<std::size_t, std::pair<std::string, std::string>>& between() const { return between_; }
  /// A fault of the names of the columns.
  void refuseHead(const std::string& what) const;
  /// Whether no artifact was given, as the instrument brings its own; else a fault. @param of it: "the ball".
  bool bringsArtifact(const std::string& instrument, const std::string& of) const;

 private:
  struct Said {
    std::string key, text, unitText;  // the last of the key
  };
  Said find(const std::vector<std::string>& keys, const std::string& mapped) const;
  /// What the table says of the unit of a column, as its name.
  std::pair<std::string, std::string> nameAndUnit(int column) const;

  ImportContext& context_;
  TableLayout layout_;
  std::vector<Row> rows_;
  std::vector<std::pair<std::string, std::string>> head_;
  std::map<std::size_t, std::pair<std::string, std::string>> between_;
};

/// A session of contacts with one feature of unknown place, which the instrument brings.
Session ownArtifact(const ImportContext& context, const std::string& artifact, Feature feature);

}  // namespace mm
