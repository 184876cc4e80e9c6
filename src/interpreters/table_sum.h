#pragma once
#include <Eigen/Core>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "interpreters/interpreter.h"
#include "interpreters/table_text.h"

namespace mm {

/// Values at ascending positions: straight lines between them, or the value of the nearest; the values at the
/// ends beyond. SI.
class Curve {
 public:
  Curve() = default;
  /// The same everywhere.
  explicit Curve(double value) : positions_{0.0}, values_{value} {}
  Curve(std::vector<double> positions, std::vector<double> values)
      : positions_(std::move(positions)), values_(std::move(values)) {}
  /// The same points with steps in the middle between them instead of straight lines.
  Curve stepped() const;
  /// 0 of a curve without points.
  double at(double position) const;
  bool addsNothing() const;                                            ///< all its values are 0
  const std::vector<double>& positions() const { return positions_; }  ///< one alone: the same everywhere

 private:
  std::vector<double> positions_, values_;
  bool steps_ = false;
};

/// What the position of one axis adds to the motor of another, or to its own.
struct AxisTable {
  std::string input, output;  // joints
  Curve positive, negative;   // by the direction of `input`
  bool alwaysTold = false;    // of points(): also where it adds nothing
};
/// A reversal: what is added to a joint after a motion in either direction.
AxisTable reversal(const std::string& joint, double positive, double negative);

/// What the positions of several axes together add to the motor of one: linear along each, the border beyond.
struct AxesGrid {
  std::vector<std::string> inputs;  // joints
  std::string output;               // joint
  std::vector<std::vector<double>> at;
  std::vector<double> values;  // the last input fastest
  bool alwaysTold = false;     // of points(): also where it adds nothing

  double value(const CommandedState& command) const;  ///< at a command, m or rad
};

/// Motor = command + every table's value at the command: how most controllers compensate. Firmware of
/// printers first moves the place that x, y and z have together.
class TableSum : public Interpreter {
 public:
  /// Moves a place (x, y, z of the command, m) by angles between the axes, a mesh, a temperature.
  using Move = std::function<void(const CommandedState& command, Eigen::Vector3d& place)>;
  /// Tables of a controller. @param numbers as `numbers()` gives them.
  explicit TableSum(std::vector<AxisTable> tables, std::map<std::string, std::set<int>> numbers = {})
      : tables_(std::move(tables)), numbers_(std::move(numbers)) {}
  TableSum(std::vector<AxisTable> tables, std::vector<AxesGrid> grids)
      : tables_(std::move(tables)), grids_(std::move(grids)) {}
  /// @param moved joints that `move` moves or looks at, with its points over them; none: it moves nothing.
  TableSum(Move move, JointPoints moved, std::vector<AxisTable> tables = {})
      : move_(std::move(move)), moved_(std::move(moved)), tables_(std::move(tables)) {}
  std::map<std::string, double> motors(const CommandedState& command) const override;
  JointPoints points() const override;
  std::map<std::string, std::set<int>> numbers() const override { return numbers_; }

 private:
  Move move_;
  JointPoints moved_;
  std::vector<AxisTable> tables_;
  std::vector<AxesGrid> grids_;
  std::map<std::string, std::set<int>> numbers_;
};

/// x and y, as far as an angle (tangent) between two axes moves them.
JointPoints skewedJoints(double xy, double xz, double yz);
/// Puts positions of tables over `joint` among those that are known of it.
void addPoints(const std::string& joint, const std::vector<double>& positions, JointPoints& points);

/// Position of a joint. @throw InputError when the command does not have it.
double commanded(const CommandedState& command, const std::string& joint);
/// The value of one of two curves at the position of a joint, by the direction of its last motion; the mean
/// of both where that is not known. @throw InputError as commanded().
double byDirection(const CommandedState& command, const std::string& joint, const Curve& positive,
                   const Curve& negative);
/// A number of a joint in the unit of its table to SI: mm, or degrees of joints called a, b, c.
double jointUnit(const std::string& joint);
/// Each number times a unit.
std::vector<double> inUnit(std::vector<double> numbers, double unit);
/// `x` of X, X1, X_2. @throw InputError when that is no axis letter (X Y Z A B C U V W).
std::string jointOfAxis(const std::string& axis, const FilePlace& place);

}  // namespace mm
