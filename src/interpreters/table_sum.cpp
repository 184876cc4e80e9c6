#include "interpreters/table_sum.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/grid_values.h"
#include "base/text.h"
#include "base/units.h"

namespace mm {
namespace {

bool allZero(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return value == 0.0; });
}

}  // namespace

Curve Curve::stepped() const {
  Curve curve = *this;
  curve.steps_ = true;
  return curve;
}

bool Curve::addsNothing() const { return allZero(values_); }

double Curve::at(double position) const {
  if (values_.size() < 2) return values_.empty() ? 0.0 : values_[0];
  const auto [i, share] = placeAmong(positions_, position);
  if (share == 1.0 || (steps_ && share >= 0.5)) return values_[i + 1];
  if (steps_) return values_[i];
  return values_[i] + share * (values_[i + 1] - values_[i]);
}

AxisTable reversal(const std::string& joint, double positive, double negative) {
  return {joint, joint, Curve(positive), Curve(negative)};
}

double AxesGrid::value(const CommandedState& command) const {
  std::vector<double> position;
  for (const std::string& input : inputs) position.push_back(commanded(command, input));
  return gridValue(gridCorners(at, position), values);
}

std::map<std::string, double> TableSum::motors(const CommandedState& command) const {
  std::map<std::string, double> motors = command.position;
  if (!moved_.empty()) {
    Eigen::Vector3d place(commanded(command, "x"), commanded(command, "y"), commanded(command, "z"));
    move_(command, place);
    for (Eigen::Index a = 0; a < 3; ++a) motors[std::string(1, "xyz"[a])] = place[a];
  }
  for (const AxisTable& table : tables_) {
    const auto motor = motors.find(table.output);
    if (motor != motors.end())
      motor->second += byDirection(command, table.input, table.positive, table.negative);
  }
  for (const AxesGrid& grid : grids_)
    if (const auto motor = motors.find(grid.output); motor != motors.end())
      motor->second += grid.value(command);
  return motors;
}

JointPoints TableSum::points() const {
  JointPoints points = moved_;
  for (const AxisTable& table : tables_) {
    if (!table.alwaysTold && table.positive.addsNothing() && table.negative.addsNothing()) continue;
    points[table.output];
    addPoints(table.input, table.positive.positions(), points);
    addPoints(table.input, table.negative.positions(), points);
  }
  for (const AxesGrid& grid : grids_) {
    if (!grid.alwaysTold && allZero(grid.values)) continue;
    points[grid.output];
    for (std::size_t a = 0; a < grid.at.size(); ++a) addPoints(grid.inputs[a], grid.at[a], points);
  }
  return points;
}

JointPoints skewedJoints(double xy, double xz, double yz) {
  JointPoints joints;
  if (xy != 0.0 || xz != 0.0) joints["x"];
  if (yz != 0.0) joints["y"];
  return joints;
}

void addPoints(const std::string& joint, const std::vector<double>& positions, JointPoints& points) {
  constexpr double kSame = 1e-9;  // m or rad: rounding of units
  std::vector<double>& known = points[joint];
  if (positions.size() < 2) return;
  known.insert(known.end(), positions.begin(), positions.end());
  std::sort(known.begin(), known.end());
  known.erase(
      std::unique(known.begin(), known.end(), [](double a, double b) { return std::abs(b - a) < kSame; }),
      known.end());
}

double commanded(const CommandedState& command, const std::string& joint) {
  const auto found = command.position.find(joint);
  if (found == command.position.end())
    throw InputError("a table of the controller needs the position of joint '" + joint +
                     "', which is not commanded; command it, too");
  return found->second;
}

double byDirection(const CommandedState& command, const std::string& joint, const Curve& positive,
                   const Curve& negative) {
  const double position = commanded(command, joint);
  const auto found = command.direction.find(joint);
  const int direction = found == command.direction.end() ? 0 : found->second;
  if (direction > 0) return positive.at(position);
  if (direction < 0) return negative.at(position);
  return 0.5 * (positive.at(position) + negative.at(position));
}

double jointUnit(const std::string& joint) {
  const bool rotary = joint == "a" || joint == "b" || joint == "c";
  return rotary ? kDegree : kMillimetre;
}

std::vector<double> inUnit(std::vector<double> numbers, double unit) {
  for (double& number : numbers) number *= unit;
  return numbers;
}

std::string jointOfAxis(const std::string& axis, const FilePlace& place) {
  const std::string name = lower(axis);
  constexpr std::string_view kLetters = "xyzabcuvw";
  const bool letter = !name.empty() && kLetters.find(name[0]) != std::string_view::npos;
  const bool numbered = name.find_first_not_of("0123456789_", 1) == std::string::npos;
  if (!letter || !numbered)
    refuse(place, "'" + axis + "' is not an axis; use X, Y, Z, A, B, C, U, V or W, with or without a number");
  return name.substr(0, 1);
}

}  // namespace mm
