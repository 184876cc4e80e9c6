#include "interpreters/error_tables.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kMicroradian = 1e-6;
const std::vector<std::string> kChainColumns = {"joint",       "kind",        "direction_x",
                                                "direction_y", "direction_z", "origin_x_mm",
                                                "origin_y_mm", "origin_z_mm", "rotation_about"};

struct GridRow {
  std::vector<std::string> cells;
  FilePlace place;
};

/// Cells of the lines below the line of names, which is the first row; lines of # are remarks.
std::vector<GridRow> gridRows(const std::filesystem::path& file) {
  std::vector<GridRow> rows;
  for (const TextLine& line : textLines(file)) {
    const std::string_view text = trim(line.text);
    if (text.empty() || text[0] == '#') continue;
    rows.push_back({partsBetween(text, ','), line.place});
    if (rows.back().cells.size() > rows.front().cells.size())
      refuse(line.place, std::to_string(rows.back().cells.size()) + " cells below " +
                             std::to_string(rows.front().cells.size()) + " columns");
    rows.back().cells.resize(rows.front().cells.size());
  }
  if (rows.empty()) refuse({file, 0}, "is empty: a line of column names is expected");
  return rows;
}

void needColumns(const GridRow& names, const std::vector<std::string>& expected) {
  if (names.cells == expected) return;
  refuse(names.place,
         "columns '" + joined(names.cells, ",") + "' instead of '" + joined(expected, ",") + "'");
}

Eigen::Vector3d vectorOf(const GridRow& row, std::size_t first, double unit, const std::string& what) {
  Eigen::Vector3d vector;
  for (int k = 0; k < 3; ++k) vector[k] = unit * tableNumber(row.cells[first + k], row.place, what);
  return vector;
}

/// 0 to 2: X, Y, Z; 3 to 5: A, B, C. -1: none of these.
int errorCoordinate(char letter) {
  const std::size_t at = std::string_view("XYZABC").find(letter);
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

/// EXX … of a file's name in any case.
bool isComponentName(const std::string& name) {
  return name.size() == 3 && name[0] == 'E' && errorCoordinate(name[1]) >= 0;
}

}  // namespace

ErrorTables::ErrorTables(const std::filesystem::path& folder) {
  readChain(folder / "chain.csv");
  locations_.resize(chain_.size());
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (lower(entry.path().extension().string()) == ".csv") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const std::string name = capitals(file.stem().string());
    if (isComponentName(name)) readComponent(file);
    if (name == "LOCATION") readLocations(file);
  }
}

void ErrorTables::readChain(const std::filesystem::path& file) {
  const std::vector<GridRow> rows = gridRows(file);
  needColumns(rows.front(), kChainColumns);
  bool ended = false;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const GridRow& row = rows[i];
    if (ended) refuse(row.place, "stands behind tip, which ends the chain");
    const Eigen::Vector3d origin = vectorOf(row, 5, kMillimetre, "origin");
    if (row.cells[0] == "tip") {
      tip_ = origin;
      ended = true;
      continue;
    }
    ChainJoint joint;
    joint.name = row.cells[0];
    joint.origin = origin;
    if (row.cells[1] != "linear" && row.cells[1] != "rotary")
      refuse(row.place, "kind: '" + row.cells[1] + "' is neither linear nor rotary");
    joint.rotary = row.cells[1] == "rotary";
    if (row.cells[8] != "fixed_side" && row.cells[8] != "carriage")
      refuse(row.place, "rotation_about: '" + row.cells[8] + "' is neither fixed_side nor carriage");
    joint.aboutCarriage = row.cells[8] == "carriage";
    const Eigen::Vector3d direction = vectorOf(row, 2, 1.0, "direction");
    constexpr double kUnitLength = 1e-3;  // rounding of the file
    if (std::abs(direction.norm() - 1.0) > kUnitLength)
      refuse(row.place, "direction: its length is " + std::to_string(direction.norm()) + " instead of 1");
    joint.direction = direction.normalized();
    for (const ChainJoint& before : chain_)
      if (before.name == joint.name) refuse(row.place, "joint '" + joint.name + "' is there twice");
    chain_.push_back(joint);
  }
  if (chain_.empty()) refuse({file, 0}, "has no joint");
  if (!ended)
    refuse({file, 0}, "the last line is not tip: where the tool is from the last joint is not known");
}

std::size_t ErrorTables::jointCalled(char letter, const FilePlace& place) const {
  const std::string name(1, static_cast<char>(std::tolower(letter)));
  for (std::size_t j = 0; j < chain_.size(); ++j)
    if (chain_[j].name == name) return j;
  refuse(place, "joint '" + name + "' is not in chain.csv");
}

void ErrorTables::readComponent(const std::filesystem::path& file) {
  const std::string name = capitals(file.stem().string());
  const std::size_t j = jointCalled(name[2], {file, 0});
  const int coordinate = errorCoordinate(name[1]);
  const std::string unit = coordinate < 3 ? "um" : "urad";
  const double factor = coordinate < 3 ? kMicrometre : kMicroradian;
  const std::string position = chain_[j].rotary ? "position_deg" : "position_mm";
  const std::vector<GridRow> rows = gridRows(file);
  const bool twoWays = rows.front().cells.size() == 3;
  needColumns(rows.front(), twoWays
                                ? std::vector<std::string>{position, "positive_" + unit, "negative_" + unit}
                                : std::vector<std::string>{position, "value_" + unit});
  std::vector<double> positions, positive, negative;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const GridRow& row = rows[i];
    const double at =
        tableNumber(row.cells[0], row.place, position) * (chain_[j].rotary ? kDegree : kMillimetre);
    if (!positions.empty() && at <= positions.back())
      refuse(row.place, position + ": " + row.cells[0] + " is not above that of the line before");
    positions.push_back(at);
    positive.push_back(factor * tableNumber(row.cells[1], row.place, rows.front().cells[1]));
    negative.push_back(twoWays ? factor * tableNumber(row.cells[2], row.place, rows.front().cells[2])
                               : positive.back());
  }
  if (positions.empty()) refuse({file, 0}, "has no values");
  components_.push_back({j, coordinate, {positions, positive}, {positions, negative}});
}

void ErrorTables::readLocations(const std::filesystem::path& file) {
  const std::vector<GridRow> rows = gridRows(file);
  needColumns(rows.front(), {"error", "value_um", "value_urad"});
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const GridRow& row = rows[i];
    const std::string name = capitals(row.cells[0]);
    const int coordinate = name.size() == 3 ? errorCoordinate(name[0]) : -1;
    if (coordinate < 0 || (name[1] != '0' && name[1] != 'O'))
      refuse(row.place, "error: '" + row.cells[0] + "' is no error of location or orientation like C0Y");
    const bool angular = coordinate >= 3;
    if (!row.cells[angular ? 1 : 2].empty())
      refuse(row.place, name + (angular ? " is an angle: value_um must be empty"
                                        : " is a length: value_urad must be empty"));
    SmallMotion& location = locations_[jointCalled(name[2], row.place)];
    const std::string& cell = row.cells[angular ? 2 : 1];
    if (angular)
      location.rotation[coordinate - 3] += kMicroradian * tableNumber(cell, row.place, "value_urad");
    else
      location.translation[coordinate] += kMicrometre * tableNumber(cell, row.place, "value_um");
  }
}

JointPoints ErrorTables::points() const {
  JointPoints points;
  for (const ChainJoint& joint : chain_) points[joint.name];
  for (const Component& component : components_) {
    addPoints(chain_[component.joint].name, component.positive, points);
    addPoints(chain_[component.joint].name, component.negative, points);
  }
  return points;
}

SmallMotion ErrorTables::component(std::size_t joint, const CommandedState& command) const {
  SmallMotion errors;
  for (const Component& component : components_) {
    if (component.joint != joint) continue;
    const std::string& name = chain_[joint].name;
    const double position = commanded(command, name);
    const double value =
        byDirection(command, name, component.positive.at(position), component.negative.at(position));
    if (component.coordinate < 3)
      errors.translation[component.coordinate] += value;
    else
      errors.rotation[component.coordinate - 3] += value;
  }
  return errors;
}

}  // namespace mm
