// Marlin: gcode/calibrate/M852.cpp, module/planner.h (skew), gcode/calibrate/M425.cpp, feature/backlash.cpp.
// Skew factors are refused beyond SKEW_FACTOR_MIN and MAX, -1 and 1 in Configuration.h. BACKLASH_CORRECTION
// is 0 there: without F no backlash is taken up.
// RepRapFirmware: GCodes2.cpp (M556), Move.cpp (AxisTransform); the page of M425 says that steps are added
// where a motor reverses, and does not say on which side: as in Marlin, the state before the first reversal
// is taken as forwards.
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr const char* kAxisLetters = "XYZABCUVW";

/// A command of a file of G-code with the numbers behind its letters.
struct GcodeCommand {
  std::string name;                // M852
  std::vector<std::string> words;  // I0.001
  FilePlace place;

  /// The letters with their numbers. @throw InputError for a letter that is not `allowed`, or no number.
  std::map<char, double> numbers(const std::string& allowed) const {
    std::map<char, double> numbers;
    for (const std::string& word : words) {
      if (allowed.find(word[0]) == std::string::npos)
        refuse(place, name + ": '" + word + "' is none of the letters " + allowed + " with its number");
      numbers[word[0]] = tableNumber(word.substr(1), place, name + " " + word[0]);
    }
    return numbers;
  }
};

/// The commands of a file, without remarks and numbers of lines. @throw InputError: lengths in inches.
std::vector<GcodeCommand> gcodeCommands(const std::filesystem::path& file) {
  std::vector<GcodeCommand> commands;
  for (const TextLine& line : textLines(file)) {
    std::vector<std::string> words =
        wordsBetweenBlanks(capitals(line.text.substr(0, line.text.find_first_of(";(*"))));
    if (!words.empty() && words[0][0] == 'N') words.erase(words.begin());
    if (words.empty()) continue;
    if (words[0] == "G20")
      refuse(line.place, "G20: lengths in inches are not read; give them in mm, and G21");
    commands.push_back({words[0], {words.begin() + 1, words.end()}, line.place});
  }
  return commands;
}

/// Takes the axes of M425 over; F and S are no axes. m, rad.
void takeGaps(const std::map<char, double>& words, std::map<std::string, double>& gaps) {
  for (const auto& [letter, size] : words) {
    if (letter == 'F' || letter == 'S') continue;
    const std::string joint(1, static_cast<char>(std::tolower(letter)));
    gaps[joint] = size * jointUnit(joint);
  }
}

/// Backwards the whole of each is taken off. @param share of them that counts.
std::vector<AxisTable> reversalsOf(const std::map<std::string, double>& gaps, double share) {
  std::vector<AxisTable> reversals;
  for (const auto& [joint, size] : gaps) reversals.push_back(reversal(joint, 0.0, -(share * size)));
  return reversals;
}

}  // namespace

std::unique_ptr<Interpreter> interpretMarlin(const std::filesystem::path& folder) {
  std::map<char, double> factors = {{'I', 0.0}, {'J', 0.0}, {'K', 0.0}};
  std::map<std::string, double> gaps;
  double correction = 0.0;
  for (const GcodeCommand& command : gcodeCommands(folder / "compensation.gcode")) {
    if (command.name == "M852")
      for (const auto& [letter, factor] : command.numbers("IJK")) {
        if (!(std::abs(factor) <= 1.0))
          refuse(command.place, format("M852 %c: %f is not within -1 to 1 (SKEW_FACTOR_MIN, SKEW_FACTOR_MAX)",
                                       letter, factor));
        factors[letter] = factor;
      }
    if (command.name != "M425") continue;
    const std::map<char, double> words = command.numbers(std::string("FS") + kAxisLetters);
    takeGaps(words, gaps);
    constexpr double kAllOn = 255.0;  // the fraction is kept in a byte
    if (words.count('F') > 0)
      correction = std::floor(std::clamp(words.at('F'), 0.0, 1.0) * kAllOn + 0.5) / kAllOn;
  }
  const double xy = factors['I'], xz = factors['J'], yz = factors['K'];
  const auto skew = [=](const CommandedState&, Eigen::Vector3d& place) {
    const double x = place.x() / kMillimetre, y = place.y() / kMillimetre, z = place.z() / kMillimetre;
    place.x() = (x - y * xy - z * (xz - xy * yz)) * kMillimetre;
    place.y() = (y - z * yz) * kMillimetre;
  };
  return std::make_unique<TableSum>(skew, skewedJoints(xy, xz, yz), reversalsOf(gaps, correction));
}

std::unique_ptr<Interpreter> interpretReprapfirmware(const std::filesystem::path& folder) {
  double xy = 0.0, yz = 0.0, xz = 0.0;  // tangents
  std::map<std::string, double> gaps;
  for (const char* name : {"config.g", "config-override.g"}) {
    if (!std::filesystem::exists(folder / name)) continue;
    for (const GcodeCommand& command : gcodeCommands(folder / name)) {
      if (command.name == "M556") {
        const std::map<char, double> words = command.numbers("SXYZ");
        if (words.count('S') == 0 || !(words.at('S') > 0.0))
          refuse(command.place, "M556: X, Y and Z count only with S above 0, the height");
        for (const auto& [letter, length] : words)
          if (letter != 'S') (letter == 'X' ? xy : letter == 'Y' ? yz : xz) = length / words.at('S');
      }
      if (command.name != "M425") continue;
      takeGaps(command.numbers(std::string("S") + kAxisLetters), gaps);
      for (const auto& [joint, size] : gaps)
        if (size < 0.0) refuse(command.place, "M425 " + capitals(joint) + ": is below 0");
    }
  }
  if (!std::filesystem::exists(folder / "config.g") && !std::filesystem::exists(folder / "config-override.g"))
    refuse({folder, 0}, "has neither config.g nor config-override.g, which reprapfirmware reads");
  const auto skew = [=](const CommandedState&, Eigen::Vector3d& place) {
    place.x() += xy * place.y() + xz * place.z();
    place.y() += yz * place.z();
  };
  return std::make_unique<TableSum>(skew, skewedJoints(xy, xz, yz), reversalsOf(gaps, 1.0));
}

}  // namespace mm
