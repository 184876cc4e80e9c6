// The package's own tables (docs/interpreters.md): component errors of ISO 230-1 with the kinematic chain
// that they belong to. A value is where the axis really is less where it should be; linear motors are moved
// so that the tip is where it was commanded.
#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>

#include "base/dense.h"
#include "base/rotation.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr double kMicroradian = 1e-6;

/// A small displacement, then a small rotation, m and rad, in the axes of the fixed side of a joint.
using SmallMotion = Eigen::Matrix<double, 6, 1>;

/// One error of a joint by its position: along (0 to 2: x, y, z) or about (3 to 5) an axis.
struct Component {
  int coordinate = 0;
  Curve positive, negative;
};

/// One line of chain.csv.
struct ChainJoint {
  std::string name;
  bool rotary = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  // unit vector, axes of the fixed side
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();     // from the joint before, axes of its moving side, m
  std::vector<Component> components;

  SmallMotion errors(const CommandedState& command) const {
    SmallMotion errors = SmallMotion::Zero();
    for (const Component& component : components)
      errors[component.coordinate] += byDirection(command, name, component.positive, component.negative);
    return errors;
  }
};

/// Lines of a file below its line of names; lines of # are remarks.
TextTable csvTable(const std::filesystem::path& file) {
  TextTable table;
  for (const TextLine& line : textLines(file))
    if (const std::string_view text = trim(line.text); !text.empty() && text[0] != '#')
      table.add(partsBetween(text, ','), line.place);
  if (table.names.cells.empty()) refuse({file, 0}, "is empty: a line of column names is expected");
  return table;
}

void needColumns(const TextTable& table, const std::vector<std::string>& expected) {
  if (table.names.cells != expected)
    refuse(table.names.place,
           "columns '" + joined(table.names.cells, ",") + "' instead of '" + joined(expected, ",") + "'");
}

Eigen::Vector3d vectorOf(const TableRow& row, std::size_t first, double unit, const std::string& what) {
  Eigen::Vector3d vector;
  for (int k = 0; k < 3; ++k) vector[k] = unit * tableNumber(row.cells[first + k], row.place, what);
  return vector;
}

/// From workpiece to tool; the last one, `tip`, has an origin alone.
std::vector<ChainJoint> readChain(const std::filesystem::path& file) {
  const TextTable table = csvTable(file);
  needColumns(table, {"joint", "kind", "direction_x", "direction_y", "direction_z", "origin_x_mm",
                      "origin_y_mm", "origin_z_mm", "rotation_about"});
  std::vector<ChainJoint> chain;
  for (const TableRow& row : table.rows) {
    if (!chain.empty() && chain.back().name == "tip")
      refuse(row.place, "stands behind tip, which ends the chain");
    ChainJoint joint;
    joint.name = row.cells[0];
    joint.origin = vectorOf(row, 5, kMillimetre, "origin");
    for (const ChainJoint& before : chain)
      if (before.name == joint.name) refuse(row.place, "joint '" + joint.name + "' is there twice");
    if (joint.name != "tip") {
      joint.rotary = row.cells[1] == "rotary";
      if (!joint.rotary && row.cells[1] != "linear")
        refuse(row.place, "kind: '" + row.cells[1] + "' is neither linear nor rotary");
      if (row.cells[8] != "fixed_side")
        refuse(row.place, "rotation_about: '" + row.cells[8] + "' is not read, only fixed_side");
      const Eigen::Vector3d direction = vectorOf(row, 2, 1.0, "direction");
      constexpr double kUnitLength = 1e-3;  // rounding of the file
      if (std::abs(direction.norm() - 1.0) > kUnitLength)
        refuse(row.place, "direction: its length is " + std::to_string(direction.norm()) + " instead of 1");
      joint.direction = direction.normalized();
    }
    chain.push_back(joint);
  }
  if (chain.size() < 2 || chain.back().name != "tip")
    refuse({file, 0}, "the last line below a joint is not tip: where the tool is from it is not known");
  return chain;
}

/// Reads EXX.csv … into the joint of its third letter; other names are left alone.
void readComponent(const std::filesystem::path& file, std::vector<ChainJoint>& chain) {
  const std::string name = capitals(file.stem().string());
  const std::size_t coordinate = name.size() == 3 ? std::string_view("XYZABC").find(name[1]) : 6;
  if (name[0] != 'E' || coordinate > 5) return;
  const std::string letter(1, static_cast<char>(std::tolower(name[2])));
  const auto joint = std::find_if(chain.begin(), chain.end(),
                                  [&](const ChainJoint& of) { return of.name == letter && !of.rotary; });
  if (joint == chain.end()) refuse({file, 0}, "joint '" + letter + "' is not a linear joint of chain.csv");
  const TextTable table = csvTable(file);
  const std::string unit = coordinate < 3 ? "um" : "urad";
  const bool twoWays = table.names.cells.size() == 3;
  const std::string up = (twoWays ? "positive_" : "value_") + unit,
                    down = (twoWays ? "negative_" : "value_") + unit;
  needColumns(table, twoWays ? std::vector<std::string>{"position_mm", up, down}
                             : std::vector<std::string>{"position_mm", up});
  const std::vector<double> positions = inUnit(table.rising("position_mm"), kMillimetre);
  const double si = coordinate < 3 ? kMicrometre : kMicroradian;
  joint->components.push_back({static_cast<int>(coordinate),
                               {positions, inUnit(table.numbers(up), si)},
                               {positions, inUnit(table.numbers(down), si)}});
}

struct ChainPose {
  Eigen::Vector3d tip;
  Eigen::Matrix3Xd directions;  // of the linear joints in the workpiece, a column each
};

class CsvInterpreter : public Interpreter {
 public:
  explicit CsvInterpreter(std::vector<ChainJoint> chain) : chain_(std::move(chain)) {}

  std::map<std::string, double> motors(const CommandedState& command) const override {
    const std::size_t joints = chain_.size() - 1;
    std::vector<SmallMotion> errors;
    Eigen::VectorXd position(joints);
    for (std::size_t j = 0; j < joints; ++j) {
      position[j] = commanded(command, chain_[j].name);
      errors.push_back(chain_[j].errors(command));
    }
    const ChainPose ideal = pose(position, std::vector<SmallMotion>(joints, SmallMotion::Zero()));
    Eigen::VectorXd driven = position;
    constexpr int kRounds = 3;  // each leaves the square of the errors of the one before
    for (int round = 0; round < kRounds && ideal.directions.cols() > 0; ++round) {
      const ChainPose real = pose(driven, errors);
      const Eigen::VectorXd step = leastSquares(real.directions, ideal.tip - real.tip);
      int linear = 0;
      for (std::size_t j = 0; j < joints; ++j)
        if (!chain_[j].rotary) driven[j] += step[linear++];
    }
    std::map<std::string, double> motors = command.position;
    for (std::size_t j = 0; j < joints; ++j) motors[chain_[j].name] = driven[j];
    return motors;
  }

  JointPoints points() const override {
    JointPoints points;
    for (std::size_t j = 0; j + 1 < chain_.size(); ++j) {
      points[chain_[j].name];
      for (const Component& component : chain_[j].components)
        addPoints(chain_[j].name, component.positive.positions(), points);
    }
    return points;
  }

 private:
  /// The component errors of each joint at its fixed side, then its motion.
  ChainPose pose(const Eigen::VectorXd& position, const std::vector<SmallMotion>& errors) const {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    Eigen::Matrix3Xd directions(3, 0);
    for (std::size_t j = 0; j < errors.size(); ++j) {
      const ChainJoint& joint = chain_[j];
      const Eigen::Vector3d travel = joint.direction * position[static_cast<Eigen::Index>(j)];
      frame.translate(joint.origin).translate(errors[j].head<3>()).rotate(rotationBy(errors[j].tail<3>()));
      if (joint.rotary) {
        frame.rotate(rotationBy(travel));
      } else {
        directions.conservativeResize(3, directions.cols() + 1);
        directions.rightCols<1>() = frame.linear() * joint.direction;
        frame.translate(travel);
      }
    }
    return {frame * chain_.back().origin, directions};
  }

  std::vector<ChainJoint> chain_;  // the last is the tip
};

}  // namespace

std::unique_ptr<Interpreter> interpretCsv(const std::filesystem::path& folder) {
  std::vector<ChainJoint> chain = readChain(folder / "chain.csv");
  if (const auto location = folder / "location.csv"; std::filesystem::exists(location))
    refuse({location, 0},
           "errors of location are not read; put squareness into the straightness (EYX.csv …)");
  for (const auto& file : filesEndingIn({".csv"}, folder)) readComponent(file, chain);
  return std::make_unique<CsvInterpreter>(std::move(chain));
}

}  // namespace mm
