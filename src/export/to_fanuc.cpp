#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/format.h"
#include "base/quantity_words.h"
#include "base/tiny.h"
#include "base/units.h"
#include "export/fitted_tables.h"
#include "export/targets.h"

namespace mm {
namespace {

constexpr double kOfAMultiplier = 1e-6;  // of a multiplier: rounding of the unit that was typed

constexpr int kFanucSections = 120;  // of at most 128 an axis
constexpr int kNumbersAnAxis = 128;
constexpr long kMostIncrement = 7;  // of one point
constexpr long kMostMagnification = 100;
constexpr double kLeastIntervalSeconds = 60.0 / 7500.0;  // of the rapid rate: mm/min / 7500 are mm
constexpr int kCellSamples = 16;
constexpr double kHardlyHeld = 0.5;  // of a curve: more than this left by the steps is told

/// Pitch error data of one axis.
struct Pitch {
  double interval = 0.0;    // m
  int first = 0, last = 0;  // grid points by their distance from the reference position, in intervals
  long magnification = 1;
  std::vector<long> increments;     // of the sections that end at first + 1 … last
  double mean = 0.0;                // of the curve over the range, m
  double before = 0.0, left = 0.0;  // RMS of the curve about its mean, and of what steps leave of it, m
};

/// Whole multiples whose sums follow the curve: each takes over what the one before left. Rounded about the
/// curve's mean, so that rounding never makes it worse.
std::vector<long> incrementsOf(const std::vector<double>& curve, double mean, double unit) {
  std::vector<long> increments;
  for (std::size_t i = 1; i < curve.size(); ++i)
    increments.push_back(std::lround((curve[i] - mean) / unit) - std::lround((curve[i - 1] - mean) / unit));
  return increments;
}

/// The mean of the table over the places of the range that are nearest to each point: what steps in the
/// middle between the points follow best.
std::vector<double> cellMeans(const LineTable& table, const ExportAxis& axis, Pitch& pitch) {
  std::vector<double> means;
  double sum = 0.0, squares = 0.0, within = 0.0;
  int count = 0;
  for (int n = pitch.first; n <= pitch.last; ++n) {
    const double from = std::clamp((n - 0.5) * pitch.interval, axis.lower, axis.upper);
    const double to = std::clamp((n + 0.5) * pitch.interval, axis.lower, axis.upper);
    double mean = 0.0, square = 0.0;
    for (int i = 0; i < kCellSamples; ++i) {
      const double value = table.value(axis.joint, from + (i + 0.5) / kCellSamples * (to - from), 0.0);
      mean += value / kCellSamples;
      square += value * value / kCellSamples;
    }
    means.push_back(mean);
    if (!(to > from)) continue;
    ++count;
    sum += mean;
    squares += square;
    within += square - mean * mean;
  }
  if (count == 0) return means;
  pitch.mean = sum / count;
  pitch.before = std::sqrt(std::max(0.0, squares / count - pitch.mean * pitch.mean));
  pitch.left = std::sqrt(std::max(0.0, within / count));
  return means;
}

/// Both directions together there is something to add, beside a reversal.
bool bends(const LineTable& adds, int joint) {
  double most = 0.0;
  for (std::size_t i = 0; i < adds.at.size(); ++i) most = std::max(most, std::abs(adds.mean(joint, i)));
  return most > LineTable::kLeastOfATable;
}

/// Steps of the table that was active, where it had equal ones that a new one may have; else 0.
double activeInterval(const NeededCorrection& needed, const ExportAxis& axis, double length, double least) {
  const std::vector<double> points = needed.activePoints(axis.joint);
  if (points.size() < 2) return 0.0;
  const double step = points[1] - points[0];
  const bool equal = std::abs(points.back() - points[0] - (points.size() - 1) * step) < kOfAWhole * step;
  return equal && step > least * (1.0 - kOfAWhole) && length / step < kFanucSections - 1 + kOfAWhole ? step
                                                                                                     : 0.0;
}

/// The active table's value at each point, which it holds to the middle of the sections beside it.
void addActiveSteps(const NeededCorrection& needed, const ExportAxis& axis, const Pitch& pitch,
                    std::vector<double>& curve) {
  if (needed.active() == nullptr) return;
  const auto at = [&](double position) {
    return meanCorrection(needed, axis.joint, position, &NeededCorrection::activeAt)[axis.joint];
  };
  for (std::size_t i = 0; i < curve.size(); ++i)
    curve[i] += at((pitch.first + static_cast<int>(i)) * pitch.interval) - at(0.0);
}

/// @param least interval that the control can follow at its rapid rate, m. @throw InputError where the
/// increments are larger than the control takes.
Pitch pitchOf(const NeededCorrection& needed, const ExportAxis& axis, const LineTable& table, double unit,
              double least) {
  const auto [lower, upper] = needed.tabulated(axis.joint);
  const double from = std::min(0.0, lower), to = std::max(0.0, upper);
  Pitch pitch;
  pitch.interval = activeInterval(needed, axis, to - from, least);
  if (pitch.interval == 0.0) {
    const double interval = std::max((to - from) / (kFanucSections - 1), least);
    pitch.interval = std::ceil(interval / kMicrometre - kOfAWhole) * kMicrometre;
  }
  pitch.first = static_cast<int>(std::floor(from / pitch.interval + kOfAWhole));
  pitch.last = static_cast<int>(std::ceil(to / pitch.interval - kOfAWhole));
  std::vector<double> curve = cellMeans(table, axis, pitch);
  addActiveSteps(needed, axis, pitch, curve);
  long most = 0;
  for (pitch.magnification = 1; pitch.magnification <= kMostMagnification; ++pitch.magnification) {
    pitch.increments = incrementsOf(curve, pitch.mean, unit * pitch.magnification);
    most = 0;
    for (const long increment : pitch.increments) most = std::max(most, std::abs(increment));
    if (most <= kMostIncrement) return pitch;
  }
  throw InputError(
      format("--to fanuc: axis %s: the correction rises by %ld x 100 detection units within %.4g mm, at "
             "most 7 x 100 can be told (3623); take a larger --detection-unit-um than %.4g, where the "
             "control has it",
             capital(axis.letter).c_str(), most, pitch.interval / kMillimetre, unit / kMicrometre));
}

/// Where `count` numbers of pitch error data in a row are free, from `from` on. @throw InputError: nowhere.
int freeNumbers(const std::set<int>& taken, int from, int count) {
  constexpr int kLast = 1023;
  for (int first = from; first + count - 1 <= kLast; ++first) {
    const auto next = taken.lower_bound(first);
    if (next == taken.end() || *next >= first + count) return first;
    first = *next;
  }
  if (from > 0) return freeNumbers(taken, 0, count);
  throw InputError(
      format("--to fanuc: no %d numbers of pitch error data in a row are free: the axes that stay "
             "as they are take %zu of 1024; give theirs less",
             count, taken.size()));
}

/// Bits of 1013 for the least command increment, and 1820 for the detection unit. @throw InputError where
/// 1820 has no number for it.
struct Units {
  std::string increment;
  int multiplier = 2;

  explicit Units(double unit) {
    const bool fine = unit < 0.5e-6;  // IS-C, 0.1 um; else IS-B, 1 um
    increment = fine ? "00000010" : "00000000";
    const double ratio = (fine ? 1e-7 : 1e-6) / unit;
    const double value = ratio > 0.499999 ? 2.0 * ratio : 100.0 + 1.0 / ratio;
    multiplier = static_cast<int>(std::lround(value));
    const bool there = ratio > 0.499999 ? multiplier <= 96 : multiplier <= 127;
    if (!there || std::abs(value - multiplier) > kOfAMultiplier)
      throw InputError(
          format("--detection-unit-um %.4g: the command multiplier (1820) has no number for it; take 1, "
                 "0.5, 0.1, 0.05 or what the control has",
                 unit / kMicrometre));
  }
};

/// Parameters of the axes, each a line with all that have it.
class FanucParameterLines {
 public:
  void add(int parameter, int axis, const std::string& value) {
    std::string& line = lines_[parameter];
    if (line.empty()) line = format("N%05d", parameter);
    line += format(" A%d P", axis) + value;
  }
  /// Those of the parameters that an axis has, in this order.
  std::string text(const std::vector<int>& parameters) const {
    std::string text;
    for (const int parameter : parameters)
      if (const auto line = lines_.find(parameter); line != lines_.end()) text += line->second + "\n";
    return text;
  }

 private:
  std::map<int, std::string> lines_;
};

/// What the page says whatever the calibration is.
void addFanucWords(Exported& out) {
  out.holds = "each axis by its own position, in whole detection units; one reversal an axis";
  out.load = {
      "Back up parameters and pitch error data.",
      "Compare the control's parameters with compare.txt: 1013#1 (increment system), 1020 (names of the "
      "axes; A1, A2 … must be its axes), 1820 (detection unit), 3605#0. Only these bits count: never read "
      "the file in, for the other bits of these bytes are the machine's. Where the detection unit is "
      "another, export again with --detection-unit-um.",
      "Set PWE, read parameters.txt in EDIT mode (data N10000 is pitch error number 0).",
      "Parameters 3620 to 3624 and the data take effect after power off, and a return to the reference "
      "position."};
  out.reference =
      "Number 3620 stands at the reference position, which is taken as machine position 0 of each axis. "
      "Where the reference return leaves another coordinate (1240), shift 3620 to 3622 by it.";
  out.unverified = {
      "That a positive value moves the axis further in the positive direction is how the examples of the "
      "manual read; check with one move.",
      "Where in its section an increment is put out: the manual draws the numbers between the ends of the "
      "sections, so the middle is taken.",
      "The least interval, rapid traverse rate (mm/min) / 7500 (mm): compare it with 3624 in the control's "
      "own manual. The rapid rate is the velocity limit of the joint in the URDF unless --rapid-mm-min says "
      "it.",
      "3624 is written in mm with a decimal point (0i-D, 30i); 16i and older take it in units of the "
      "increment system without one."};
  out.notes.push_back(
      "Between two numbers the control adds the increment in one step, and so does the figure "
      "(interpolated only with the option for it); straightness compensation (5700 ff.) and bidirectional "
      "data (3605#0) are options that are not used.");
}

}  // namespace

Exported toFanuc(const NeededCorrection& needed, const ExportOptions& options) {
  Exported out;
  const double unit = options.detectionUnit;
  const StraightPart adds = straightPart(needed, &NeededCorrection::adds),
                     active = straightPart(needed, &NeededCorrection::activeAt);
  const Units as(unit);
  FanucParameterLines lines;
  std::string data;
  std::vector<std::pair<int, LineTable>> written;  // number of the axis
  std::set<int> taken;                             // numbers of pitch error data
  int n = 0;
  for (const int joint : needed.linear()) {
    const ExportAxis& axis = needed.axis(joint);
    ++n;
    if (!needed.moved(joint) && needed.activePoints(joint).empty()) continue;
    LineTable table = lineTable(needed, joint, 481, &NeededCorrection::adds);
    const bool reversed = std::abs(2.0 * adds.byTravel(joint, joint)) > 0.5 * unit;
    if (!reversed && !bends(table, joint)) continue;
    out.axes.insert(axis.letter);
    written.emplace_back(n, std::move(table));
  }
  if (needed.active() != nullptr)
    for (const auto& [letter, numbers] : needed.active()->numbers())
      if (out.axes.count(letter) == 0) taken.insert(numbers.begin(), numbers.end());
  for (const auto& [number, table] : written) {
    const int joint = table.input;
    const ExportAxis& axis = needed.axis(joint);
    addNotFollowed(needed, table, {joint}, out);
    lines.add(1013, number, as.increment);
    lines.add(1820, number, std::to_string(as.multiplier));
    lines.add(1020, number, std::to_string(static_cast<int>(capital(axis.letter)[0])));
    lines.add(3605, number, "00000000");
    const long gap = std::lround(2.0 * (adds.byTravel(joint, joint) + active.byTravel(joint, joint)) / unit);
    if (std::abs(2.0 * adds.byTravel(joint, joint)) > 0.5 * unit || needed.active() != nullptr)
      lines.add(1851, number, std::to_string(gap));
    if (!bends(table, joint) && needed.activePoints(joint).empty()) continue;
    const double limit = needed.model().machine().joints()[joint].maxVelocity;
    const double rapid = options.rapidRate > 0.0 ? options.rapidRate : limit;
    const Pitch pitch = pitchOf(needed, axis, table, unit, rapid * kLeastIntervalSeconds);
    const int first = freeNumbers(taken, (number - 1) * kNumbersAnAxis, pitch.last - pitch.first + 1);
    for (int i = 0; i <= pitch.last - pitch.first; ++i) taken.insert(first + i);
    const int zero = first - pitch.first;
    lines.add(3620, number, std::to_string(zero));
    lines.add(3621, number, std::to_string(zero + pitch.first + 1));
    lines.add(3622, number, std::to_string(zero + pitch.last));
    lines.add(3623, number, std::to_string(pitch.magnification));
    lines.add(3624, number, fixed(pitch.interval / kMillimetre, 4));
    for (std::size_t i = 0; i < pitch.increments.size(); ++i)
      data +=
          format("N%05d P%ld\n", 10000 + zero + pitch.first + 1 + static_cast<int>(i), pitch.increments[i]);
    const std::string letter = capital(axis.letter);
    out.notes.push_back(
        format("%s: %zu sections of %.4g mm; the least at a rapid rate of %.4g mm/min is %.4g mm.",
               letter.c_str(), pitch.increments.size(), pitch.interval / kMillimetre,
               rapid / kMillimetre * 60.0, rapid * kLeastIntervalSeconds / kMillimetre));
    if (pitch.left > kHardlyHeld * pitch.before)
      out.notFollowed.push_back(
          format("the correction of %s bends within the sections of %.4g mm: %s of %s of it (RMS) are left",
                 letter.c_str(), pitch.interval / kMillimetre, errorInWords(pitch.left, false).c_str(),
                 errorInWords(pitch.before, false).c_str()));
    if (pitch.magnification > 1)
      out.notes.push_back(
          format("%s rises by more than 7 detection units between two points: magnification %ld.",
                 letter.c_str(), pitch.magnification));
  }
  out.files = {
      {"parameters.txt", "parameters and pitch error data in detection units, as the control punches them",
       "%\n" + lines.text({1851, 3620, 3621, 3622, 3623, 3624}) + data + "%\n"},
      {"compare.txt",
       "what the control must have already, to be compared and never read in: 1013#1 (increment "
       "system), 1020 (names of the axes), 1820 (detection unit), 3605#0 (one table for both "
       "directions)",
       "%\n" + lines.text({1013, 1020, 1820, 3605}) + "%\n"}};
  addFanucWords(out);
  return out;
}

}  // namespace mm
