// FANUC: Parameter Manual B-63980EN, page 100 (3620 to 3624, example of increments by section). An increment
// belongs to the section before its number and is put out in one step; one after the other they are the
// absolute compensation, 0 at the reference position. Assumed, for the pages that can be read leave it open:
// that the step is in the middle of the section, between whose ends the manual draws the number; that a
// positive one moves the axis in the positive direction; that backlash (1851) is first taken up backwards.
#include <algorithm>
#include <optional>

#include "base/format.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr int kLastFanucPoint = 1023, kFirstFanucIncrement = 10000, kMostIncrement = 7;
constexpr int kMostFanucAxes = 32, kMostFanucBacklash = 9999;

std::string parameterName(int number, int axis) {
  return "parameter " + std::to_string(number) + (axis > 0 ? " A" + std::to_string(axis) : "");
}

/// N03620 A1 P40 A2 P60: letters with what follows them; axis 0: of no axis.
void readFanucLine(const TextLine& line, KeyedValues& parameters) {
  std::string text = capitalsWithoutBlanks(line.text);
  text = text.substr(0, text.find_first_of(";("));
  if (text.empty() || text[0] != 'N') return;
  int number = -1, axis = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of("0123456789.+-", at + 1), text.size());
    const std::string value = text.substr(at + 1, end - at - 1), word = text.substr(at, end - at);
    if (text[at] == 'N')
      number = tableInteger(value, line.place, "number of the parameter", 0, 99999);
    else if (text[at] == 'A')
      axis = tableInteger(value, line.place, word, 1, kMostFanucAxes);
    else if (text[at] == 'P')
      parameters.set(parameterName(number, axis), value, line.place);
    else if (text[at] != 'Q' && text[at] != 'L' && text[at] != 'S')
      refuse(line.place, "'" + word + "' is not a word of a parameter: N, Q, L, A, S, P");
    at = end;
  }
}

/// Pitch error compensation and backlash of one axis.
class FanucAxis {
 public:
  FanucAxis(const KeyedValues& parameters, int axis, std::string joint)
      : p_(parameters), axis_(axis), joint_(std::move(joint)) {
    if (jointUnit(joint_) != kMillimetre || bit(1006, 0))
      p_.refuse(name(p_.has(name(3620)) ? 3620 : 1851), "rotary axes are not read; take the axis out");
    if (bit(3605, 0)) p_.refuse(name(3605), "a table for each direction (#0) is not read");
    increment_ = bit(1013, 1) ? 1e-4 : 1e-3;  // IS-C, IS-B
    detection_ = increment_ / commandMultiplier();
  }

  std::vector<AxisTable> tables() {
    std::vector<AxisTable> tables;
    const double backlash =
        p_.integer(name(1851), -kMostFanucBacklash, kMostFanucBacklash, 0) * detection_ * kMillimetre;
    if (backlash != 0.0) tables.push_back(reversal(joint_, 0.0, -backlash));
    if (!p_.has(name(3620)) || interval() == 0.0) return tables;
    if (!(interval() > 0.0)) p_.refuse(name(3624), "is not above 0");
    const Curve curve = pitch().stepped();
    tables.push_back({joint_, joint_, curve, curve});
    return tables;
  }
  const std::set<int>& numbers() const { return numbers_; }  ///< of pitch error data, once tables() was asked

 private:
  std::string name(int number) const { return parameterName(number, axis_); }

  /// A bit of eight, #0 at the right.
  bool bit(int number, std::size_t which) const {
    const TextLine* value = p_.find(name(number));
    if (value == nullptr) return false;
    const std::string& text = value->text;
    if (text.empty() || text.size() > 8 || text.find_first_not_of("01") != std::string::npos)
      p_.refuse(name(number), "'" + text + "' is not a byte of bits");
    return which < text.size() && text[text.size() - 1 - which] == '1';
  }

  /// 1820: twice the ratio of the least command increment to the detection unit, of a ratio below 0.5 its
  /// inverse + 100.
  double commandMultiplier() const {
    constexpr int kMostMultiplier = 127, kInverse = 100, kOne = 2;
    const int value = p_.integer(name(1820), 1, kMostMultiplier, kOne);
    return value > kInverse ? 1.0 / (value - kInverse) : 0.5 * value;
  }

  /// mm: with a decimal point as it is, else in least increments.
  double interval() const {
    const double read = p_.number(name(3624), 0.0);
    const bool point = p_.has(name(3624)) && p_.find(name(3624))->text.find('.') != std::string::npos;
    return point ? read : read * increment_;
  }

  Curve pitch() {
    const auto point = [&](int number) { return p_.integer(name(number), 0, kLastFanucPoint); };
    const int reference = point(3620), first = point(3621), last = point(3622);
    if (first > reference + 1 || last < reference)
      p_.refuse(name(3620),
                format("the reference position, %d, is not between the points %d (3621) and %d (3622)",
                       reference, first, last));
    p_.only(name(1240), 0);
    const int magnification = p_.integer(name(3623), 0, 100, 1);
    const auto increment = [&](int number) {
      numbers_.insert(number);
      return p_.integer(parameterName(kFirstFanucIncrement + number, 0), -kMostIncrement, kMostIncrement, 0) *
             magnification * detection_ * kMillimetre;
    };
    const auto position = [&](int number) { return (number - reference) * interval() * kMillimetre; };
    std::vector<double> positions{0.0}, values{0.0};
    for (int n = reference + 1; n <= last; ++n) {
      positions.push_back(position(n));
      values.push_back(values.back() + increment(n));
    }
    for (int n = reference; n >= first; --n) {
      positions.insert(positions.begin(), position(n - 1));
      values.insert(values.begin(), values.front() - increment(n));
    }
    return {std::move(positions), std::move(values)};
  }

  const KeyedValues& p_;
  int axis_;
  std::string joint_;
  double increment_ = 1e-3, detection_ = 1e-3;  // mm
  std::set<int> numbers_;
};

/// 1020: names of the axes as characters; without it the first three are X, Y, Z.
std::string fanucJoint(const KeyedValues& parameters, int axis) {
  const std::string name = parameterName(1020, axis);
  if (!parameters.has(name) && axis <= 3) return std::string(1, "xyz"[axis - 1]);
  return jointOfAxis(std::string(1, static_cast<char>(parameters.integer(name, 'A', 'Z'))),
                     parameters.place(name));
}

}  // namespace

std::unique_ptr<Interpreter> interpretFanuc(const std::filesystem::path& folder) {
  KeyedValues parameters({folder / "parameters.txt", 0});
  for (const char* name : {"parameters.txt", "compare.txt"}) {  // what it is given, what it has already
    if (name == std::string("compare.txt") && !std::filesystem::exists(folder / name)) continue;
    for (const TextLine& line : textLines(folder / name)) readFanucLine(line, parameters);
  }
  std::vector<AxisTable> tables;
  std::map<std::string, std::set<int>> numbers;
  for (int axis = 1; axis <= kMostFanucAxes; ++axis) {
    if (!parameters.has(parameterName(3620, axis)) && !parameters.has(parameterName(1851, axis))) continue;
    const std::string joint = fanucJoint(parameters, axis);
    FanucAxis read(parameters, axis, joint);
    for (AxisTable& table : read.tables()) tables.push_back(std::move(table));
    numbers[joint] = read.numbers();
  }
  return std::make_unique<TableSum>(std::move(tables), std::move(numbers));
}

}  // namespace mm
