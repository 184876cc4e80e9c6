#include "export/to_fanuc.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "export/fitted_tables.h"

namespace mm {
namespace {

constexpr int kFanucSections = 120;  // of at most 128 an axis
constexpr int kNumbersAnAxis = 128;
constexpr long kMostIncrement = 7;  // of one point; the magnification is 1 to 100

/// Pitch error data of one axis.
struct Pitch {
  double interval = 0.0;    // m
  int first = 0, last = 0;  // grid points by their distance from the reference position, in intervals
  long magnification = 1;
  std::vector<long> increments;  // of the sections that end at first + 1 … last
};

/// Whole multiples whose sum follows the curve: each takes over what the one before left.
std::vector<long> incrementsOf(const std::vector<double>& curve, double unit) {
  std::vector<long> increments;
  long sum = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const long wanted = std::lround((curve[i] - curve[0]) / unit);
    increments.push_back(wanted - sum);
    sum = wanted;
  }
  return increments;
}

Pitch pitchOf(const NeededCorrection& needed, const ExportAxis& axis, double unit) {
  const LineTable table = lineTable(needed, axis.joint, 481);
  const double from = std::min(0.0, axis.lower), to = std::max(0.0, axis.upper);
  Pitch pitch;
  pitch.interval = std::ceil((to - from) / (kFanucSections - 1) / kMicrometre - 1e-6) * kMicrometre;
  pitch.first = static_cast<int>(std::floor(from / pitch.interval + 1e-9));
  pitch.last = static_cast<int>(std::ceil(to / pitch.interval - 1e-9));
  std::vector<double> curve;
  for (int n = pitch.first; n <= pitch.last; ++n)
    curve.push_back(table.value(axis.joint, n * pitch.interval, 0.0));
  for (pitch.magnification = 1; pitch.magnification < 100; ++pitch.magnification) {
    pitch.increments = incrementsOf(curve, unit * static_cast<double>(pitch.magnification));
    const auto most = std::max_element(pitch.increments.begin(), pitch.increments.end(),
                                       [](long a, long b) { return std::abs(a) < std::abs(b); });
    if (most == pitch.increments.end() || std::abs(*most) <= kMostIncrement) break;
  }
  return pitch;
}

/// Lines of one parameter, an axis each.
class Parameter1 {
 public:
  explicit Parameter1(int number) : text_(format("N%05d", number)) {}
  void add(int axis, const std::string& value) { text_ += format(" A%d P", axis) + value; }
  std::string line() const { return text_ + "\n"; }

 private:
  std::string text_;
};

}  // namespace

Exported toFanuc(const NeededCorrection& needed, const ExportOptions& options) {
  Exported out;
  const double unit = options.detectionUnit;
  const StraightPart part = straightPart(needed);
  Parameter1 units(1013), names(1020), backlash(1851), reference(3620), lowest(3621), highest(3622),
      magnify(3623), interval(3624), both(3605);
  std::string data;
  int n = 0;
  for (const int joint : needed.linear()) {
    const ExportAxis& axis = needed.axes()[static_cast<std::size_t>(joint)];
    if (!needed.moved(joint)) continue;
    ++n;
    const Pitch pitch = pitchOf(needed, axis, unit);
    const int zero = (n - 1) * kNumbersAnAxis - pitch.first;
    units.add(n, unit < 0.5e-6 ? "00000010" : "00000000");
    names.add(n, std::to_string(static_cast<int>(capital(axis.letter)[0])));
    both.add(n, "00000000");
    backlash.add(n, std::to_string(std::lround(2.0 * part.byTravel(joint, joint) / unit)));
    reference.add(n, std::to_string(zero));
    lowest.add(n, std::to_string(zero + pitch.first + 1));
    highest.add(n, std::to_string(zero + pitch.last));
    magnify.add(n, std::to_string(pitch.magnification));
    interval.add(n, fixed(pitch.interval / kMillimetre, 4));
    for (std::size_t i = 0; i < pitch.increments.size(); ++i)
      data +=
          format("N%05d P%ld\n", 10000 + zero + pitch.first + 1 + static_cast<int>(i), pitch.increments[i]);
    if (pitch.magnification > 1)
      out.notes.push_back(
          format("%s rises by more than 7 detection units between two points: magnification %ld.",
                 capital(axis.letter).c_str(), pitch.magnification));
  }
  const std::string parameters = units.line() + names.line() + backlash.line() + both.line() +
                                 reference.line() + lowest.line() + highest.line() + magnify.line() +
                                 interval.line();
  out.files = {{"parameters.txt",
                "parameters and pitch error data in detection units, as the control punches them",
                "%\n" + parameters + data + "%\n"}};
  out.holds = "each axis by its own position, in whole detection units; one reversal an axis";
  out.load = {
      "Back up parameters and pitch error data.",
      "Compare 1013 (increment system) and 1020 (names of the axes) with the control's; they are there to be "
      "compared, and A1, A2 … must be its axes. Where its detection unit is another, export again with "
      "--detection-unit-um.",
      "Set PWE, read parameters.txt in EDIT mode (data N10000 is pitch error number 0).",
      "Parameters 3620 to 3624 and the data take effect after power off, and a return to the reference "
      "position."};
  out.reference =
      "Number 3620 stands at the reference position, which is taken as machine position 0 of each axis. "
      "Where the reference return leaves another coordinate (1240), shift 3620 to 3622 by it.";
  out.unverified = {
      "That a positive value moves the axis further in the positive direction is how the examples of the "
      "manual read; check with one move.",
      "3624 is written in mm with a decimal point (0i-D, 30i); 16i and older take it in units of the "
      "increment system without one."};
  out.notes.push_back(
      "Between two numbers the control adds the increment in one step (interpolated only with the "
      "option for it); straightness compensation (5700 ff.) and bidirectional data (3605#0) are options "
      "that are not used.");
  return out;
}

}  // namespace mm
