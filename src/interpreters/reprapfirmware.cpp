// RepRapFirmware: GCodes2.cpp (M556), Move.cpp (AxisTransform); the page of M425 says that steps are added
// where a motor reverses, and does not say on which side: as in Marlin, the state before the first reversal
// is taken as forwards.
#include "base/error.h"
#include "base/units.h"
#include "interpreters/gcode_lines.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

struct RrfSettings {
  double xy = 0.0, yz = 0.0, xz = 0.0;  // tangents
  bool compensateX = true;              // P0: XY is taken up by X, else by Y
  ReversalBacklash backlash;
};

class RrfInterpreter : public Interpreter {
 public:
  explicit RrfInterpreter(RrfSettings settings) : settings_(std::move(settings)) {}

  std::map<std::string, double> motors(const CommandedState& command) const override {
    std::map<std::string, double> motors = command.position;
    const RrfSettings& s = settings_;
    if (s.xy != 0.0 || s.yz != 0.0 || s.xz != 0.0) {
      // one axis after the other: with P1 the Y axis sees X as it is after its own compensation
      const double z = commanded(command, "z");
      double x = commanded(command, "x"), y = commanded(command, "y");
      x += (s.compensateX ? s.xy * y : 0.0) + s.xz * z;
      y += (s.compensateX ? 0.0 : s.xy * x) + s.yz * z;
      motors["x"] = x;
      motors["y"] = y;
    }
    for (auto& [joint, motor] : motors) {
      const auto direction = command.direction.find(joint);
      motor += s.backlash.added(joint, direction == command.direction.end() ? 0 : direction->second);
    }
    return motors;
  }

  JointPoints points() const override {
    JointPoints points;
    const RrfSettings& s = settings_;
    if (s.xz != 0.0 || (s.xy != 0.0 && s.compensateX)) points["x"];
    if (s.yz != 0.0 || (s.xy != 0.0 && !s.compensateX)) points["y"];
    s.backlash.addTo(points);
    return points;
  }

 private:
  RrfSettings settings_;
};

void readAxisCompensation(const GcodeCommand& command, RrfSettings& settings) {
  auto words = command.words();
  const auto value = [&](char letter) {
    if (!words[letter]) refuse(command.place, std::string("M556 ") + letter + ": has no value");
    return *words[letter];
  };
  const bool any = words.count('X') + words.count('Y') + words.count('Z') > 0;
  for (const auto& [letter, number] : words)
    if (std::string_view("SXYZP").find(letter) == std::string_view::npos)
      refuse(command.place, std::string("M556: parameter ") + letter + " is none of S, X, Y, Z, P");
  if (any && words.count('S') == 0) refuse(command.place, "M556: X, Y and Z count only with S, the height");
  if (words.count('S') > 0) {
    const double height = value('S');
    if (!(height > 0.0)) refuse(command.place, "M556 S: " + std::to_string(height) + " is not above 0");
    if (words.count('X') > 0) settings.xy = value('X') / height;
    if (words.count('Y') > 0) settings.yz = value('Y') / height;
    if (words.count('Z') > 0) settings.xz = value('Z') / height;
  }
  if (words.count('P') > 0) settings.compensateX = value('P') <= 0.0;
}

void readRrfBacklash(const GcodeCommand& command, double unit, RrfSettings& settings) {
  for (const auto& [letter, value] : command.words()) {
    if (letter == 'S') continue;  // over which distance the steps are added
    const std::string joint = jointOfAxis(std::string(1, letter), command.place);
    if (!value) refuse(command.place, std::string("M425 ") + letter + ": has no value");
    if (*value < 0.0)
      refuse(command.place, std::string("M425 ") + letter + ": " + std::to_string(*value) + " is below 0");
    settings.backlash.set(joint, *value * (jointUnit(joint) == kDegree ? kDegree : unit * kMillimetre));
  }
}

}  // namespace

std::unique_ptr<Interpreter> interpretReprapfirmware(const std::filesystem::path& folder) {
  RrfSettings settings;
  bool found = false;
  for (const char* name : {"config.g", "config-override.g"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    found = true;
    constexpr double kInch = 25.4;
    double unit = 1.0;
    for (const GcodeCommand& command : gcodeCommands(folder / name)) {
      if (command.name == "G20") unit = kInch;
      if (command.name == "G21") unit = 1.0;
      if (command.name == "M556") readAxisCompensation(command, settings);
      if (command.name == "M425") readRrfBacklash(command, unit, settings);
    }
  }
  if (!found)
    throw InputError(folder.string() +
                     ": has neither config.g nor config-override.g, which reprapfirmware reads");
  return std::make_unique<RrfInterpreter>(std::move(settings));
}

}  // namespace mm
