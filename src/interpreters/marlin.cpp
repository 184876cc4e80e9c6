// Marlin: gcode/calibrate/M852.cpp, module/planner.h (skew), gcode/calibrate/M425.cpp, feature/backlash.cpp.
// Skew factors are value_linear_units, so G20 counts 25.4 times; they are refused beyond SKEW_FACTOR_MIN and
// MAX, -1 and 1 in Configuration.h. BACKLASH_CORRECTION is 0 there: without F no backlash is taken up.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/gcode_lines.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

struct MarlinAxisLimits {
  double lower = -std::numeric_limits<double>::infinity(),
         upper = std::numeric_limits<double>::infinity();  // mm
  bool holds(double value, double margin = 0.0) const { return value >= lower + margin && value <= upper; }
};

struct MarlinSettings {
  double xy = 0.0, xz = 0.0, yz = 0.0;  // skew factors
  MarlinAxisLimits x, y;
  double correction = 0.0;                  // part of the backlash that is taken up
  std::map<std::string, double> distances;  // backlash, m, rad
};

class MarlinInterpreter : public Interpreter {
 public:
  explicit MarlinInterpreter(MarlinSettings settings) : settings_(std::move(settings)) {
    for (const auto& [joint, distance] : settings_.distances)
      backlash_.set(joint, settings_.correction * distance);
  }

  std::map<std::string, double> motors(const CommandedState& command) const override {
    std::map<std::string, double> motors = command.position;
    if (settings_.xy != 0.0 || settings_.xz != 0.0 || settings_.yz != 0.0) skew(command, motors);
    for (auto& [joint, motor] : motors) {
      const auto direction = command.direction.find(joint);
      motor += backlash_.added(joint, direction == command.direction.end() ? 0 : direction->second);
    }
    return motors;
  }

  JointPoints points() const override {
    JointPoints points;
    const MarlinSettings& s = settings_;
    if (s.xy != 0.0 || s.xz != 0.0) points["x"];
    if (s.yz != 0.0) points["y"];
    backlash_.addTo(points);
    return points;
  }

 private:
  /// Nothing is skewed where the command, or what comes of it, is beyond the machine.
  void skew(const CommandedState& command, std::map<std::string, double>& motors) const {
    const double x = commanded(command, "x") / kMillimetre, y = commanded(command, "y") / kMillimetre,
                 z = commanded(command, "z") / kMillimetre;
    const MarlinSettings& s = settings_;
    if (!s.x.holds(x, 1.0) || !s.y.holds(y, 1.0)) return;
    const double skewedX = x - y * s.xy - z * (s.xz - s.xy * s.yz), skewedY = y - z * s.yz;
    if (!s.x.holds(skewedX) || !s.y.holds(skewedY)) return;
    motors["x"] = skewedX * kMillimetre;
    motors["y"] = skewedY * kMillimetre;
  }

  MarlinSettings settings_;
  ReversalBacklash backlash_;
};

void readSkewFactors(const GcodeCommand& command, double unit, MarlinSettings& settings) {
  const auto words = command.words();
  for (const auto& [letter, value] : words) {
    double* factor = letter == 'I' || letter == 'S' ? &settings.xy
                     : letter == 'J'                ? &settings.xz
                     : letter == 'K'                ? &settings.yz
                                                    : nullptr;
    if (factor == nullptr)
      refuse(command.place, std::string("M852: parameter ") + letter + " is none of I, J, K, S");
    if (letter == 'S' && words.count('I') > 0) continue;  // I comes first
    if (!value) refuse(command.place, std::string("M852 ") + letter + ": has no value");
    const double taken = *value * unit;
    if (!(std::abs(taken) <= 1.0))
      refuse(command.place, std::string("M852 ") + letter + ": " + std::to_string(taken) +
                                " is not within -1 to 1 (SKEW_FACTOR_MIN, SKEW_FACTOR_MAX)");
    *factor = taken;
  }
}

void readMarlinBacklash(const GcodeCommand& command, double unit, MarlinSettings& settings) {
  for (const auto& [letter, value] : command.words()) {
    const std::string place = std::string("M425 ") + letter;
    if (letter == 'S') continue;  // smoothing: over which distance, not how much
    if (!value) refuse(command.place, place + ": has no value; what G29 measured is not known here");
    if (letter == 'F') {
      constexpr double kAllOn = 255.0;  // the fraction is kept in a byte
      settings.correction = std::floor(std::clamp(*value, 0.0, 1.0) * kAllOn + 0.5) / kAllOn;
      continue;
    }
    const std::string joint = jointOfAxis(std::string(1, letter), command.place);
    settings.distances[joint] = *value * (jointUnit(joint) == kDegree ? kDegree : unit * kMillimetre);
  }
}

void readMarlinLimits(const std::filesystem::path& file, MarlinSettings& settings) {
  for (const TextLine& line : textLines(file)) {
    const std::vector<std::string> words = wordsBetweenBlanks(line.text);
    if (words.size() < 3 || words[0] != "#define") continue;
    double* limit = words[1] == "X_MIN_POS"   ? &settings.x.lower
                    : words[1] == "X_MAX_POS" ? &settings.x.upper
                    : words[1] == "Y_MIN_POS" ? &settings.y.lower
                    : words[1] == "Y_MAX_POS" ? &settings.y.upper
                                              : nullptr;
    if (limit != nullptr) *limit = tableNumber(words[2], line.place, words[1]);
  }
}

}  // namespace

std::unique_ptr<Interpreter> interpretMarlin(const std::filesystem::path& folder) {
  MarlinSettings settings;
  constexpr double kMillimetresInAnInch = 25.4;
  double unit = 1.0;
  for (const GcodeCommand& command : gcodeCommands(folder / "compensation.gcode")) {
    if (command.name == "G20") unit = kMillimetresInAnInch;
    if (command.name == "G21") unit = 1.0;
    if (command.name == "M852") readSkewFactors(command, unit, settings);
    if (command.name == "M425") readMarlinBacklash(command, unit, settings);
  }
  const std::filesystem::path configuration = folder / "Configuration.h";
  if (std::filesystem::exists(configuration)) readMarlinLimits(configuration, settings);
  return std::make_unique<MarlinInterpreter>(std::move(settings));
}

}  // namespace mm
