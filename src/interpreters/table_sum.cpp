#include "interpreters/table_sum.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"

namespace mm {

Curve Curve::stepped() const {
  Curve curve = *this;
  curve.steps_ = true;
  return curve;
}

double Curve::at(double position) const {
  if (values_.empty()) return 0.0;
  if (period_ > 0.0) {
    const double first = positions_.front();
    position = first + std::fmod(position - first, period_);
    if (position < first) position += period_;
  }
  if (position <= positions_.front()) return values_.front();
  if (position >= positions_.back()) return values_.back();
  const auto above = std::upper_bound(positions_.begin(), positions_.end(), position);
  const auto i = static_cast<std::size_t>(above - positions_.begin());
  const double part = (position - positions_[i - 1]) / (positions_[i] - positions_[i - 1]);
  if (steps_) return part < 0.5 ? values_[i - 1] : values_[i];
  return values_[i - 1] + part * (values_[i] - values_[i - 1]);
}

std::map<std::string, double> TableSum::motors(const CommandedState& command) const {
  std::map<std::string, double> motors = command.position;
  for (const AxisTable& table : tables_) {
    const auto motor = motors.find(table.output);
    if (motor == motors.end()) continue;
    const double position = commanded(command, table.input);
    motor->second +=
        byDirection(command, table.input, table.positive.at(position), table.negative.at(position));
  }
  return motors;
}

double commanded(const CommandedState& command, const std::string& joint) {
  const auto found = command.position.find(joint);
  if (found == command.position.end())
    throw InputError("a table of the controller needs the position of joint '" + joint +
                     "', which is not commanded; command it, too");
  return found->second;
}

double byDirection(const CommandedState& command, const std::string& joint, double positive,
                   double negative) {
  const auto found = command.direction.find(joint);
  const int direction = found == command.direction.end() ? 0 : found->second;
  if (direction > 0) return positive;
  if (direction < 0) return negative;
  return 0.5 * (positive + negative);
}

double jointUnit(const std::string& joint) {
  const bool rotary = joint == "a" || joint == "b" || joint == "c";
  return rotary ? kDegree : kMillimetre;
}

std::string jointOfAxis(const std::string& axis, const FilePlace& place) {
  const std::string name = lower(axis);
  constexpr std::string_view kLetters = "xyzabcuvw";
  const bool letter = !name.empty() && kLetters.find(name[0]) != std::string_view::npos;
  const bool numbered = name.find_first_not_of("0123456789_", 1) == std::string::npos;
  if (!letter || !numbered)
    refuse(place, "'" + axis + "' is no axis; X, Y, Z, A, B, C, U, V, W, with a number or without");
  return name.substr(0, 1);
}

}  // namespace mm
