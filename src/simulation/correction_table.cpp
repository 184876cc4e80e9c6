#include "simulation/correction_table.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "base/error.h"
#include "base/grid_values.h"
#include "base/nearest_name.h"
#include "base/number_text.h"
#include "base/read_file.h"
#include "base/text.h"
#include "machine/joint_units.h"

namespace mm {
namespace {

constexpr std::size_t kMostNodes = 2000000;

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) cells.emplace_back(trim(cell));
  if (!line.empty() && line.back() == ',') cells.emplace_back();
  return cells;
}

/// What one column of the table is.
struct Column {
  int joint = 0;
  enum class Role { kPosition, kTravel, kCorrection } role = Role::kPosition;
  double unit = 1.0;  // SI = number * unit
};

Column columnOf(const std::string& name, const std::string& where, const Machine& machine) {
  std::vector<std::string> known;
  for (int j = 0; j < machine.jointCount(); ++j) {
    const Joint& joint = machine.joints()[static_cast<std::size_t>(j)];
    const JointUnit reading = readingUnit(joint), error = errorUnit(joint);
    const std::pair<std::string, Column> columns[] = {
        {joint.name + "_" + reading.symbol, {j, Column::Role::kPosition, reading.factor}},
        {joint.name + "_travel", {j, Column::Role::kTravel, 1.0}},
        {"correction_" + joint.name + "_" + error.symbol, {j, Column::Role::kCorrection, error.factor}}};
    for (const auto& [called, column] : columns) {
      if (name == called) return column;
      known.push_back(called);
    }
  }
  throw InputError(where + ": column '" + name + "' is not known" + didYouMean(name, known) + "; known are " +
                   joined(known, ", "));
}

/// The rows as they stand in the text.
struct TableText {
  std::string source;
  std::vector<Column> columns;
  std::vector<std::vector<double>> rows;  // SI
  std::vector<int> lines;

  std::string at(int line) const { return source + ":" + std::to_string(line); }

  void header(const std::string& line, int number, const Machine& machine) {
    const std::vector<std::string> names = cellsOf(line);
    for (const std::string& name : names) {
      if (std::count(names.begin(), names.end(), name) > 1)
        throw InputError(at(number) + ": column '" + name + "' stands there twice");
      columns.push_back(columnOf(name, at(number), machine));
    }
  }

  void row(const std::string& line, int number) {
    const std::vector<std::string> cells = cellsOf(line);
    if (cells.size() != columns.size())
      throw InputError(at(number) + ": " + std::to_string(cells.size()) + " cells under " +
                       std::to_string(columns.size()) + " columns");
    std::vector<double> values;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      double value = 0.0;
      if (!parseNumber(cells[c], value) || !std::isfinite(value))
        throw InputError(at(number) + ": '" + cells[c] + "' is not a finite number");
      values.push_back(value * columns[c].unit);
      if (columns[c].role == Column::Role::kTravel && std::abs(values.back()) != 1.0)
        throw InputError(at(number) + ": '" + cells[c] + "' is not a direction of travel; give -1 or 1");
    }
    rows.push_back(std::move(values));
    lines.push_back(number);
  }
};

}  // namespace

CorrectionTable CorrectionTable::parse(const std::string& text, const std::string& source,
                                       const Machine& machine) {
  TableText reading;
  reading.source = source;
  std::istringstream in(text);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::string plain(trim(line));
    if (plain.empty() || plain[0] == '#') continue;
    if (reading.columns.empty())
      reading.header(plain, number, machine);
    else
      reading.row(plain, number);
  }
  CorrectionTable table;
  std::vector<std::size_t> place, value;  // columns
  for (std::size_t c = 0; c < reading.columns.size(); ++c) {
    const Column& column = reading.columns[c];
    if (column.role == Column::Role::kCorrection) {
      table.corrected_.push_back(column.joint);
      value.push_back(c);
      continue;
    }
    std::set<double> nodes;
    for (const auto& row : reading.rows) nodes.insert(row[c]);
    table.coordinates_.push_back({column.joint, column.role == Column::Role::kTravel});
    table.nodes_.emplace_back(nodes.begin(), nodes.end());
    place.push_back(c);
  }
  if (value.empty() || reading.rows.empty())
    throw InputError(source +
                     ": the table corrects nothing; it needs a column correction_<joint>_um and rows");
  std::size_t nodes = 1;
  for (const auto& along : table.nodes_) nodes = std::min(kMostNodes + 1, nodes * along.size());
  if (nodes != reading.rows.size())
    throw InputError(
        source + ": " + std::to_string(reading.rows.size()) +
        " rows, but its positions and directions make a grid of " +
        (nodes > kMostNodes ? "more than " + std::to_string(kMostNodes) : std::to_string(nodes)) +
        " nodes; give every combination once");
  table.values_.assign(nodes * value.size(), std::nan(""));
  for (std::size_t r = 0; r < reading.rows.size(); ++r) {
    std::size_t node = 0;
    for (std::size_t c = 0; c < place.size(); ++c) {
      const std::vector<double>& all = table.nodes_[c];
      node = node * all.size() +
             static_cast<std::size_t>(std::lower_bound(all.begin(), all.end(), reading.rows[r][place[c]]) -
                                      all.begin());
    }
    if (!std::isnan(table.values_[node * value.size()]))
      throw InputError(reading.at(reading.lines[r]) + ": a row for this place stands there already");
    for (std::size_t v = 0; v < value.size(); ++v)
      table.values_[node * value.size() + v] = reading.rows[r][value[v]];
  }
  return table;
}

CorrectionTable CorrectionTable::load(const std::filesystem::path& file, const Machine& machine) {
  return parse(readWholeFile(file, "check the path of the correction table"), file.string(), machine);
}

std::vector<double> CorrectionTable::drives(const std::vector<double>& command,
                                            const std::vector<double>& travel) const {
  std::vector<double> at;
  for (const Coordinate& c : coordinates_)
    at.push_back((c.travel ? travel : command)[static_cast<std::size_t>(c.joint)]);
  std::vector<double> drives = command;
  for (const GridCorner& corner : gridCorners(nodes_, at))
    for (std::size_t v = 0; v < corrected_.size() && corner.share != 0.0; ++v)
      drives[static_cast<std::size_t>(corrected_[v])] +=
          corner.share * values_[corner.point * corrected_.size() + v];
  return drives;
}

}  // namespace mm
