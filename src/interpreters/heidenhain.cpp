// HEIDENHAIN: Technical Manual MANUALplus 620, pages 716 and 718 (AXISPOS, BACKLASH, config.cma: axis in the
// column of *.com = F(axis in the column of *.cma)); TNC 407, pages 151 to 156 and 622 (at most 256 entries).
// The pages that can be read call the values errors (TNC 407, page 153, figure) and an error positive where
// the axis goes too far (page 151); so they are taken off the command. They say nothing of positions beyond
// the table: the values at its ends are taken.
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr std::size_t kMostComEntries = 256;

/// BEGIN NAME.EXT [MM], a line of names of columns, rows with a cell for each, [END]: a table of the control.
TextTable readTncTable(const std::filesystem::path& file) {
  TextTable table;
  bool begun = false, ended = false;
  for (const TextLine& line : textLines(file)) {
    std::vector<std::string> words = wordsBetweenBlanks(capitals(line.text));
    if (words.empty() || ended) continue;
    if (!begun) {
      if (words[0] != "BEGIN")
        refuse(line.place,
               "'" + std::string(trim(line.text)) + "' instead of BEGIN and the name of the table");
      if (words.size() > 2 && words[2] != "MM")
        refuse(line.place, "unit '" + words[2] + "' is not read, only MM; give the values in mm");
      begun = true;
    } else if (words[0] == "[END]") {
      ended = true;
    } else {
      table.add(std::move(words), line.place);
    }
  }
  if (table.names.cells.empty())
    refuse({file, 0}, "is not a table: BEGIN and a line of column names are expected");
  if (!ended) refuse({file, 0}, "[END] is missing: the file is not whole");
  return table;
}

/// A linear axis of a column. @throw InputError: a rotary one.
std::string linearJoint(const std::string& column, const FilePlace& place) {
  const std::string joint = jointOfAxis(column, place);
  if (jointUnit(joint) != kMillimetre)
    refuse(place, "column " + column + ": tables of rotary axes are not read; take the column out");
  return joint;
}

/// The columns of a compensation value table as functions of the position of `input`.
void addComTables(const std::filesystem::path& file, const std::string& input,
                  std::vector<AxisTable>& tables) {
  const TextTable table = readTncTable(file);
  const std::vector<double> positions = inUnit(table.rising("AXISPOS", kMostComEntries), kMillimetre);
  const auto curve = [&](const std::string& column) {
    return Curve(positions, inUnit(table.numbers(column), -kMillimetre));
  };
  if (table.has("BACKLASH") && !table.has(capitals(input)))
    refuse(table.names.place, "BACKLASH has the values of axis " + capitals(input) +
                                  " in the negative direction, but there is no column " + capitals(input));
  for (const std::string& name : table.names.cells) {
    if (name == "NR" || name == "AXISPOS" || name == "BACKLASH") continue;
    const std::string output = linearJoint(name, table.names.place);
    const bool twoWays = table.has("BACKLASH") && output == input;
    tables.push_back({input, output, curve(name), curve(twoWays ? "BACKLASH" : name)});
  }
}

/// A file of the folder by its name in any case: the control knows no small letters.
std::filesystem::path tncFile(const std::filesystem::path& folder, const std::string& name,
                              const FilePlace& from) {
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (capitals(entry.path().filename().string()) == capitals(name)) return entry.path();
  refuse(from, "there is no table '" + (folder / name).string() + "'");
}

}  // namespace

std::unique_ptr<Interpreter> interpretHeidenhain(const std::filesystem::path& folder) {
  const TextTable assignment = readTncTable(tncFile(folder, "config.cma", {folder, 0}));
  const TableRow& names = assignment.names;
  if (names.cells.size() < 2 || names.cells[0] != "NR" || names.cells[1] != "ACTIVE")
    refuse(names.place, "columns: NR and ACTIVE are expected first");
  const TableRow* active = nullptr;
  for (const TableRow& row : assignment.rows) {
    if (row.cells.size() < 2 || row.cells[1] != "*") continue;
    if (active != nullptr) refuse(row.place, "ACTIVE: a second line is active; only one may have *");
    active = &row;
  }
  std::vector<AxisTable> tables;
  for (std::size_t i = 2; active != nullptr && i < names.cells.size(); ++i)
    if (names.cells[i] != "DOC")
      addComTables(tncFile(folder, active->cells[i], active->place), linearJoint(names.cells[i], names.place),
                   tables);
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
