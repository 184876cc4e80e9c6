// SINUMERIK: Function Manual Extended Functions, K3 (6FC5397-1BP40-3BA1, pages 237 to 249; 808D Function
// Manual 01/2017, page 106): a positive value of the leadscrew error compensation moves the axis in the
// negative direction. What is open there, and assumed: that this is so of the sag compensation, too, which K3
// describes as the same interpolatory compensation; that backlash adds nothing in the direction of the search
// for the reference.
#include <cmath>

#include "base/units.h"
#include "interpreters/siemens_tables.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

/// A table that counts, with its curve in the unit of its axes (SI).
struct SiemensCurve {
  std::string input, output;
  int direction = 0;
  double weight = 1.0;
  Curve curve;
  int multipliedBy = -1;  // index of the other table; -1: none

  double at(const CommandedState& command) const {
    const double value = weight * curve.at(commanded(command, input));
    return byDirection(command, input, direction >= 0 ? value : 0.0, direction <= 0 ? value : 0.0);
  }
};

SiemensCurve siemensCurve(const SiemensTable& table, const std::string& name) {
  const auto missing = [&](const char* what) { refuse(table.place, name + what + " is missing"); };
  if (table.input.empty()) missing("_INPUT_AXIS");
  if (table.output.empty()) missing("_OUTPUT_AXIS");
  if (!table.step) missing("_STEP");
  if (!table.min) missing("_MIN");
  if (!table.max) missing("_MAX");
  if (!(*table.step > 0.0))
    refuse(table.place, name + "_STEP: " + std::to_string(*table.step) + " is not above 0");
  if (!(*table.max > *table.min))
    refuse(table.place, name + "_MAX: " + std::to_string(*table.max) + " is not above _MIN, " +
                            std::to_string(*table.min));
  constexpr double kWhole = 1e-6;  // part of a step: rounding of the numbers in the file
  const int last = static_cast<int>(std::ceil((*table.max - *table.min) / *table.step - kWhole));
  if (table.mostPoints && last + 1 > *table.mostPoints)
    refuse(table.place, name + ": (_MAX - _MIN) / _STEP asks for " + std::to_string(last + 1) +
                            " points of at most " + std::to_string(*table.mostPoints));
  if (table.mostPoints && !table.values.empty() && table.values.rbegin()->first >= *table.mostPoints)
    refuse(table.place, name + ": point " + std::to_string(table.values.rbegin()->first) + " of at most " +
                            std::to_string(*table.mostPoints - 1));
  std::vector<double> positions, values;
  const double in = jointUnit(table.input), out = jointUnit(table.output);
  for (int n = 0; n <= last; ++n) {
    const auto value = table.values.find(n);
    positions.push_back((*table.min + n * *table.step) * in);
    values.push_back(value == table.values.end() ? 0.0 : value->second * out);
  }
  const Curve curve(positions, values);
  // the end of the table is _MAX, also where it is no whole number of steps away
  if (const double end = *table.max * in; positions.back() > end) {
    values.back() = curve.at(end);
    positions.back() = end;
  }
  const double period = table.modulo ? positions.back() - positions.front() : 0.0;
  return {table.input,           table.output, table.direction, table.weight, {positions, values, period},
          table.multipliedBy - 1};
}

class SiemensInterpreter : public Interpreter {
 public:
  explicit SiemensInterpreter(const SiemensData& data) {
    for (const auto& [index, table] : data.cec) {
      const auto enabled = data.cecEnabled.find(table.output);
      if (!table.enabled || (enabled != data.cecEnabled.end() && !enabled->second)) continue;
      const std::string name = "table " + std::to_string(index) + ": $AN_CEC";
      curves_[index] = siemensCurve(table, name);
      if (table.multipliedBy > 0 && data.cec.count(table.multipliedBy - 1) == 0)
        refuse(table.place, name + "_MULT_BY_TABLE: there is no table number " +
                                std::to_string(table.multipliedBy) + " (index " +
                                std::to_string(table.multipliedBy - 1) + ")");
    }
    for (const auto& [joint, table] : data.encoder)
      if (table.enabled) encoder_.push_back(siemensCurve(table, "axis " + joint + ": $AA_ENC_COMP"));
    for (const auto& [joint, size] : data.backlash) {
      const auto toMinus = data.referencedToMinus.find(joint);
      const bool minus = toMinus != data.referencedToMinus.end() && toMinus->second;
      const double added = size * jointUnit(joint);
      backlash_.push_back({joint, joint, Curve(minus ? added : 0.0), Curve(minus ? 0.0 : -added)});
    }
  }

  std::map<std::string, double> motors(const CommandedState& command) const override {
    std::map<std::string, double> motors = TableSum(backlash_).motors(command);
    const auto move = [&](const std::string& joint, double correction) {
      const auto motor = motors.find(joint);
      if (motor != motors.end()) motor->second -= correction;
    };
    for (const auto& [index, curve] : curves_) {
      const double value = curve.at(command);
      move(curve.output, value);
      const auto other = curves_.find(curve.multipliedBy);
      // mm x mm counts as mm: the numbers of the tables are multiplied
      if (other != curves_.end())
        move(curve.output, value * other->second.at(command) / jointUnit(other->second.output));
    }
    for (const SiemensCurve& curve : encoder_) move(curve.output, curve.at(command));
    return motors;
  }

  JointPoints points() const override {
    JointPoints points = TableSum(backlash_).points();
    const auto add = [&](const SiemensCurve& curve) {
      points[curve.output];
      addPoints(curve.input, curve.curve, points);
    };
    for (const auto& [index, curve] : curves_) add(curve);
    for (const SiemensCurve& curve : encoder_) add(curve);
    return points;
  }
  std::map<std::string, std::set<int>> numbers() const override {
    std::map<std::string, std::set<int>> numbers;
    for (const auto& [index, curve] : curves_) numbers[curve.output].insert(index);
    return numbers;
  }

 private:
  std::map<int, SiemensCurve> curves_;
  std::vector<SiemensCurve> encoder_;
  std::vector<AxisTable> backlash_;
};

}  // namespace

std::unique_ptr<Interpreter> interpretSiemens(const std::filesystem::path& folder) {
  return std::make_unique<SiemensInterpreter>(readSiemensFiles(folder));
}

}  // namespace mm
