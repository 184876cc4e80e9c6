// FANUC: Parameter Manual B-63980EN, page 100 (3620 to 3625, example of increments by section), A-77810E
// (3605#0, 3626, 3627, both directions). An increment belongs to the section before its number and is put out
// in one step; one after the other they are the absolute compensation, 0 at the reference position. Assumed,
// for the pages that can be read leave it open: that the step is in the middle of the section, between whose
// ends the manual draws the number; that a positive one moves the axis in the positive direction; that
// backlash (1851) is first taken up against the direction of the return to the reference position (1006#5).
#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr double kWholeTurn = 1e-6;  // points: rounding of the decimals of 3624 and 3625
constexpr double kClosed = 1e-12;    // m or rad: rounding of a sum of increments

constexpr int kLastFanucPoint = 1023, kFirstFanucIncrement = 10000, kMostIncrement = 7;
constexpr int kMostFanucAxes = 32;

struct FanucValue {
  std::string text;
  FilePlace place;
};

/// Parameters of a file by number and axis (0: of no axis).
class FanucParameters {
 public:
  /// @param compare values that the control must have already; may be missing.
  FanucParameters(const std::filesystem::path& file, const std::filesystem::path& compare) : file_(file) {
    for (const TextLine& line : textLines(file)) readLine(line);
    if (!std::filesystem::exists(compare)) return;
    for (const TextLine& line : textLines(compare)) readLine(line);
  }

  const FanucValue* find(int number, int axis) const {
    const auto found = values_.find({number, axis});
    return found == values_.end() ? nullptr : &found->second;
  }
  /// An integer, or `missing` where it is not given.
  int integer(int number, int axis, int lower, int upper, int missing) const {
    const FanucValue* value = find(number, axis);
    return value == nullptr ? missing
                            : tableInteger(value->text, value->place, name(number, axis), lower, upper);
  }
  /// A bit of eight, #0 at the right.
  bool bit(int number, int axis, int which) const {
    const FanucValue* value = find(number, axis);
    if (value == nullptr) return false;
    const std::string& text = value->text;
    if (text.empty() || text.size() > 8 || text.find_first_not_of("01") != std::string::npos)
      refuse(value->place, name(number, axis) + ": '" + text + "' is no byte of bits");
    return which < static_cast<int>(text.size()) && text[text.size() - 1 - which] == '1';
  }
  /// A length or an angle in mm, deg: with a decimal point as it is, else in units of `increment`.
  std::optional<double> length(int number, int axis, double increment) const {
    const FanucValue* value = find(number, axis);
    if (value == nullptr) return std::nullopt;
    const double read = tableNumber(value->text, value->place, name(number, axis));
    return value->text.find('.') == std::string::npos ? read * increment : read;
  }
  FilePlace place(int number, int axis) const {
    const FanucValue* value = find(number, axis);
    return value == nullptr ? FilePlace{file_, 0} : value->place;
  }
  static std::string name(int number, int axis) {
    return "parameter " + std::to_string(number) + (axis > 0 ? " A" + std::to_string(axis) : "");
  }

 private:
  /// N03620 A1 P40 A2 P60: letters with what follows them.
  void readLine(const TextLine& line) {
    std::string text;
    for (const char c : capitals(line.text))
      if (kBlanks.find(c) == std::string_view::npos) text += c;
    text = text.substr(0, std::min(text.find(';'), text.find('(')));
    if (text.empty() || text[0] != 'N') return;
    int number = -1, axis = 0;
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find_first_not_of("0123456789.+-", at + 1), text.size());
      const std::string value = text.substr(at + 1, end - at - 1);
      const std::string word = text.substr(at, end - at);
      if (text[at] == 'N')
        number = tableInteger(value, line.place, "number of the parameter", 0, 99999);
      else if (text[at] == 'A')
        axis = tableInteger(value, line.place, word, 1, kMostFanucAxes);
      else if (text[at] == 'P')
        add(number, axis, value, line.place);
      else if (text[at] != 'Q' && text[at] != 'L' && text[at] != 'S')
        refuse(line.place, "'" + word + "' is no word of a parameter: N, Q, L, A, S, P");
      at = end;
    }
  }
  void add(int number, int axis, const std::string& value, const FilePlace& place) {
    if (number < 0) refuse(place, "P" + value + " stands before the number N of its parameter");
    values_[{number, axis}] = {value, place};
  }

  std::filesystem::path file_;
  std::map<std::pair<int, int>, FanucValue> values_;
};

/// Pitch error compensation and backlash of one axis.
class FanucAxis {
 public:
  FanucAxis(const FanucParameters& parameters, int axis, std::string joint)
      : p_(parameters), axis_(axis), joint_(std::move(joint)) {
    unit_ = jointUnit(joint_);
    increment_ = p_.bit(1013, axis_, 1) ? 1e-4 : 1e-3;  // IS-C, IS-B
    detection_ = increment_ / commandMultiplier();
    rotary_ = p_.bit(1006, axis_, 0) || unit_ == kDegree;
    returnsToMinus_ = p_.bit(1006, axis_, 5);
  }

  std::vector<AxisTable> tables() {
    std::vector<AxisTable> tables;
    constexpr int kMostBacklash = 9999;
    const double backlash = p_.integer(1851, axis_, -kMostBacklash, kMostBacklash, 0) * detection_ * unit_;
    if (backlash != 0.0)
      tables.push_back({joint_, joint_, Curve(returnsToMinus_ ? backlash : 0.0),
                        Curve(returnsToMinus_ ? 0.0 : -backlash)});
    const double interval = p_.length(3624, axis_, increment_).value_or(0.0);
    if (p_.find(3620, axis_) == nullptr || interval == 0.0) return tables;
    if (!(interval > 0.0))
      refuse(p_.place(3624, axis_),
             FanucParameters::name(3624, axis_) + ": " + std::to_string(interval) + " is not above 0");
    readPoints();
    AxisTable pitch{joint_, joint_, curve(0, 0.0, interval), {}};
    pitch.negative = pitch.positive;
    if (p_.bit(3605, axis_, 0)) twoWays(pitch, interval);
    tables.push_back({joint_, joint_, pitch.positive.stepped(), pitch.negative.stepped()});
    for (int n = first_; n <= last_; ++n) {
      numbers_.insert(n);
      if (p_.bit(3605, axis_, 0))
        numbers_.insert(n + p_.integer(3626, axis_, 0, kLastFanucPoint, 0) - first_);
    }
    return tables;
  }
  const std::set<int>& numbers() const { return numbers_; }  ///< of pitch error data, once tables() was asked

 private:
  /// 1820: twice the ratio of the least command increment to the detection unit, of a ratio below 0.5 its
  /// inverse + 100.
  double commandMultiplier() const {
    constexpr int kMostMultiplier = 127, kInverse = 100, kOne = 2;
    const int value = p_.integer(1820, axis_, 1, kMostMultiplier, kOne);
    return value > kInverse ? 1.0 / (value - kInverse) : 0.5 * value;
  }

  int point(int number) const {
    if (p_.find(number, axis_) == nullptr)
      refuse(p_.place(3620, axis_), FanucParameters::name(number, axis_) + " is missing");
    return p_.integer(number, axis_, 0, kLastFanucPoint, 0);
  }

  void readPoints() {
    reference_ = point(3620);
    first_ = rotary_ ? reference_ : point(3621);
    last_ = point(3622);
    magnification_ = p_.integer(3623, axis_, 0, 100, 1);
    if (first_ > reference_ + 1 || last_ < reference_)
      refuse(p_.place(3620, axis_), FanucParameters::name(3620, axis_) + ": the reference position, " +
                                        std::to_string(reference_) + ", is not between the points " +
                                        std::to_string(first_) + " (3621) and " + std::to_string(last_) +
                                        " (3622)");
  }

  /// 3626 is where the table of the negative direction begins, 3627 its value at the reference position, of
  /// the direction that is against the return to it.
  void twoWays(AxisTable& pitch, double interval) {
    const int shift = point(3626) - (rotary_ ? reference_ : first_);
    if (last_ + shift > kLastFanucPoint)
      refuse(p_.place(3626, axis_),
             FanucParameters::name(3626, axis_) + ": the table of the negative direction ends at " +
                 std::to_string(last_ + shift) + ", at most " + std::to_string(kLastFanucPoint));
    constexpr int kMostAtReference = 32767;
    const double atReference =
        p_.integer(3627, axis_, -kMostAtReference, kMostAtReference, 0) * detection_ * unit_;
    pitch.positive = curve(0, returnsToMinus_ ? atReference : 0.0, interval);
    pitch.negative = curve(shift, returnsToMinus_ ? 0.0 : atReference, interval);
  }

  double increment(int number) const {
    const int value = p_.integer(kFirstFanucIncrement + number, 0, -kMostIncrement, kMostIncrement, 0);
    return value * magnification_ * detection_ * unit_;
  }

  Curve curve(int shift, double atReference, double interval) const {
    const double origin = p_.length(1240, axis_, increment_).value_or(0.0);
    std::vector<double> positions{origin * unit_}, values{atReference};
    for (int n = reference_ + 1; n <= last_; ++n) {
      positions.push_back((origin + (n - reference_) * interval) * unit_);
      values.push_back(values.back() + increment(n + shift));
    }
    if (rotary_) return turn(std::move(positions), std::move(values), interval);
    for (int n = reference_; n >= first_; --n) {
      positions.insert(positions.begin(), (origin - (reference_ - n + 1) * interval) * unit_);
      values.insert(values.begin(), values.front() - increment(n + shift));
    }
    return {std::move(positions), std::move(values)};
  }

  Curve turn(std::vector<double> positions, std::vector<double> values, double interval) const {
    const double perTurn = p_.length(3625, axis_, increment_).value_or(360.0);
    const double points = perTurn / interval;
    if (std::abs(points - (last_ - reference_)) > kWholeTurn)
      refuse(p_.place(3622, axis_), FanucParameters::name(3622, axis_) + ": " + std::to_string(last_) +
                                        " is not " + std::to_string(reference_) + " (3620) + " +
                                        std::to_string(points) + " (3625 / 3624)");
    if (std::abs(values.back() - values.front()) > kClosed)
      refuse(p_.place(3620, axis_), "increments of axis A" + std::to_string(axis_) +
                                        " do not sum to zero: the compensation would grow with every turn");
    return {std::move(positions), std::move(values), perTurn * unit_};
  }

  const FanucParameters& p_;
  int axis_;
  std::string joint_;
  double unit_ = 1.0, increment_ = 1e-3, detection_ = 1e-3;
  bool rotary_ = false, returnsToMinus_ = false;
  int reference_ = 0, first_ = 0, last_ = 0, magnification_ = 1;
  std::set<int> numbers_;
};

/// 1020: names of the axes as characters; without it the first three are X, Y, Z.
std::string fanucJoint(const FanucParameters& parameters, int axis) {
  if (const FanucValue* value = parameters.find(1020, axis)) {
    const int code = tableInteger(value->text, value->place, FanucParameters::name(1020, axis), 65, 90);
    return jointOfAxis(std::string(1, static_cast<char>(code)), value->place);
  }
  return axis <= 3 ? std::string(1, "xyz"[axis - 1]) : "";
}

}  // namespace

std::unique_ptr<Interpreter> interpretFanuc(const std::filesystem::path& folder) {
  const FanucParameters parameters(folder / "parameters.txt", folder / "compare.txt");
  std::vector<AxisTable> tables;
  std::map<std::string, std::set<int>> numbers;
  for (int axis = 1; axis <= kMostFanucAxes; ++axis) {
    const bool any = parameters.find(3620, axis) != nullptr || parameters.find(1851, axis) != nullptr;
    if (!any) continue;
    const std::string joint = fanucJoint(parameters, axis);
    if (joint.empty())
      refuse(parameters.place(parameters.find(3620, axis) != nullptr ? 3620 : 1851, axis),
             "axis A" + std::to_string(axis) + " has no name; give parameter 1020 A" + std::to_string(axis));
    FanucAxis read(parameters, axis, joint);
    for (AxisTable& table : read.tables()) tables.push_back(std::move(table));
    numbers[joint] = read.numbers();
  }
  return std::make_unique<TableSum>(std::move(tables), std::move(numbers));
}

}  // namespace mm
