// HEIDENHAIN: Technical Manual MANUALplus 620, pages 716 and 718 (AXISPOS, BACKLASH, config.cma: axis in the
// column of
// *.com = F(axis in the column of *.cma)); TNC 407, pages 151 to 156 and 622 (at most 256 entries, rotary
// axes 0 to 360 degrees). The pages that can be read call the values errors (TNC 407, page 153, figure) and
// an error positive where the axis goes too far (page 151); so they are taken off the command. They say
// nothing of positions beyond the table: the values at its ends are taken.
#include <cctype>
#include <optional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr std::size_t kMostComEntries = 256;
constexpr double kHeidenhainInch = 25.4;

struct TncRow {
  FilePlace place;
  std::map<std::string, std::string> cells;  // by name of the column
};

/// BEGIN NAME.EXT UNIT, a line of names of columns, rows, [END]: a table of the control.
struct TncTable {
  std::string unit;  // MM, INCH, or empty
  FilePlace head;    // of the names
  std::vector<std::string> columns;
  std::vector<TncRow> rows;
};

struct TncCell {
  std::size_t begin;
  std::string text;
};

std::vector<TncCell> tncCells(const std::string& text) {
  std::vector<TncCell> cells;
  for (std::size_t at = 0; (at = text.find_first_not_of(kBlanks, at)) != std::string::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
    cells.push_back({at, text.substr(at, end - at)});
    at = end;
  }
  return cells;
}

/// Cells belong to the columns in order where there is one for each, else to the name that they stand under.
TncRow tncRow(const TextLine& line, const std::vector<TncCell>& names) {
  TncRow row{line.place, {}};
  const std::vector<TncCell> cells = tncCells(line.text);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    std::size_t column = 0;
    if (cells.size() == names.size())
      column = i;
    else
      while (column + 1 < names.size() && names[column + 1].begin <= cells[i].begin) ++column;
    if (!row.cells.emplace(names[column].text, cells[i].text).second)
      refuse(line.place,
             "two values stand under " + names[column].text + "; align the columns with their names");
  }
  return row;
}

TncTable readTncTable(const std::filesystem::path& file) {
  TncTable table;
  std::vector<TncCell> names;
  bool begun = false, ended = false;
  for (const TextLine& line : textLines(file)) {
    const std::vector<std::string> words = wordsBetweenBlanks(capitals(line.text));
    if (words.empty() || ended) continue;
    if (!begun) {
      if (words[0] != "BEGIN")
        refuse(line.place,
               "'" + std::string(trim(line.text)) + "' instead of BEGIN and the name of the table");
      begun = true;
      if (words.size() > 2) table.unit = words[2];
    } else if (words[0] == "[END]" || words[0] == "END") {
      ended = true;
    } else if (names.empty()) {
      names = tncCells(capitals(line.text));
      table.head = line.place;
      for (const TncCell& name : names) table.columns.push_back(name.text);
    } else {
      table.rows.push_back(tncRow(line, names));
    }
  }
  if (names.empty()) refuse({file, 0}, "is no table: BEGIN and a line of names of columns are expected");
  if (!ended) refuse({file, 0}, "[END] is missing: the file is not whole");
  return table;
}

double tncUnit(const TncTable& table, const std::string& joint) {
  const double unit = jointUnit(joint);
  const bool inch = table.unit == "INCH" || table.unit == "IN";
  if (!inch && !table.unit.empty() && table.unit != "MM")
    refuse({table.head.file, 1}, "unit '" + table.unit + "' is neither MM nor INCH");
  return inch && unit == kMillimetre ? kHeidenhainInch * unit : unit;
}

/// The columns of a compensation value table as functions of the position of `input`.
class ComTable {
 public:
  ComTable(const std::filesystem::path& file, std::string input)
      : table_(readTncTable(file)), input_(std::move(input)), file_(file) {
    readPositions();
  }

  std::vector<AxisTable> tables() const {
    std::vector<AxisTable> tables;
    const bool backlash = has("BACKLASH");
    bool own = false;
    for (const std::string& name : table_.columns) {
      if (name == "NR" || name == "AXISPOS" || name == "BACKLASH") continue;
      const std::string output = jointOfAxis(name, table_.head);
      own = own || output == input_;
      const bool twoWays = backlash && output == input_;
      tables.push_back({input_, output, curve(name, output), curve(twoWays ? "BACKLASH" : name, output)});
    }
    if (backlash && !own)
      refuse(table_.head, "BACKLASH has the values of axis " + capitals(input_) +
                              " in the negative direction, but there is no column " + capitals(input_));
    return tables;
  }

 private:
  bool has(const std::string& column) const {
    return std::find(table_.columns.begin(), table_.columns.end(), column) != table_.columns.end();
  }

  void readPositions() {
    if (!has("AXISPOS")) refuse(table_.head, "column AXISPOS is missing");
    const double unit = tncUnit(table_, input_);
    for (const TncRow& row : table_.rows) {
      if (positions_.size() == kMostComEntries)
        refuse(row.place, "entry " + std::to_string(kMostComEntries + 1) + " of at most " +
                              std::to_string(kMostComEntries));
      const auto cell = row.cells.find("AXISPOS");
      if (cell == row.cells.end()) refuse(row.place, "AXISPOS is empty");
      const double position = tableNumber(cell->second, row.place, "AXISPOS");
      if (jointUnit(input_) == kDegree && (position < 0.0 || position > 360.0))
        refuse(row.place, "AXISPOS: " + cell->second + " is not within 0 to 360 degrees");
      if (!positions_.empty() && position * unit <= positions_.back())
        refuse(row.place, "AXISPOS: " + cell->second + " is not above that of the line before");
      positions_.push_back(position * unit);
    }
    if (positions_.empty()) refuse({file_, 0}, "has no compensation points");
  }

  Curve curve(const std::string& column, const std::string& output) const {
    std::vector<double> values;
    for (const TncRow& row : table_.rows) {
      const auto cell = row.cells.find(column);
      const double value = cell == row.cells.end() ? 0.0 : tableNumber(cell->second, row.place, column);
      values.push_back(-value * tncUnit(table_, output));
    }
    return {positions_, values, jointUnit(input_) == kDegree ? 2.0 * kPi : 0.0};
  }

  TncTable table_;
  std::string input_;
  std::filesystem::path file_;
  std::vector<double> positions_;
};

/// A file of the folder by its name in any case: the control knows no small letters.
std::filesystem::path tncFile(const std::filesystem::path& folder, const std::string& name,
                              const FilePlace& from) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (capitals(entry.path().filename().string()) == capitals(name)) return entry.path();
  refuse(from, "there is no table '" + (folder / name).string() + "'");
}

}  // namespace

std::unique_ptr<Interpreter> interpretHeidenhain(const std::filesystem::path& folder) {
  const std::filesystem::path file = tncFile(folder, "config.cma", {folder, 0});
  const TncTable assignment = readTncTable(file);
  const TncRow* active = nullptr;
  for (const TncRow& row : assignment.rows) {
    const auto cell = row.cells.find("ACTIVE");
    if (cell == row.cells.end() || cell->second != "*") continue;
    if (active != nullptr) refuse(row.place, "ACTIVE: a second line is active; only one may have *");
    active = &row;
  }
  std::vector<AxisTable> tables;
  if (active != nullptr) {
    for (const auto& [column, name] : active->cells) {
      if (column == "NR" || column == "ACTIVE" || column == "DOC") continue;
      const bool extension = capitals(name).find(".COM") != std::string::npos;
      const ComTable table(tncFile(folder, extension ? name : name + ".com", active->place),
                           jointOfAxis(column, assignment.head));
      for (AxisTable& part : table.tables()) tables.push_back(std::move(part));
    }
  }
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
