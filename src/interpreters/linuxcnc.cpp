// LinuxCNC: src/emc/motion/usrmotintf.cc (usrmotLoadComp), command.c (EMCMOT_SET_JOINT_COMP), control.c
// (compute_screw_comp), src/emc/ini/inijoint.cc. Where a joint was homed its motor offset takes up what the
// table adds there; that constant is the joint's zero, and not counted here.
#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr std::size_t kMostCompEntries = 256;  // EMCMOT_COMP_SIZE
constexpr int kMostLinuxcncJoints = 16;        // EMCMOT_MAX_JOINTS

/// A line that is no triplet ends the table, as sscanf ends LinuxCNC's loop.
TextTable compTriplets(const std::filesystem::path& file) {
  TextTable table;
  table.add({"nominal", "forward", "reverse"}, {file, 0});
  std::optional<FilePlace> end;
  for (const TextLine& line : textLines(file)) {
    std::vector<std::string> words = wordsBetweenBlanks(line.text);
    const bool triplet =
        words.size() >= 3 && words[0].find_first_not_of("+-.0123456789eE") == std::string::npos;
    if (!triplet && !end) end = line.place;
    if (!triplet) continue;
    if (end)
      refuse(*end, "is not a triplet of numbers, so LinuxCNC stops reading there, but line " +
                       std::to_string(line.place.line) + " is one; take the line out");
    words.resize(3);
    table.add(words, line.place);
  }
  return table;
}

/// The unit of a key of [TRAJ], mm or degree where it is not given. @param units words with what they are in
/// SI.
double trajUnit(const ConfigSection& traj, const std::string& key,
                const std::vector<std::pair<std::string, double>>& units) {
  const TextLine* said = traj.values.find(key);
  if (said == nullptr) return units.front().second;
  for (const auto& [word, unit] : units)
    if (lower(said->text) == word) return unit;
  refuse(said->place, key + ": '" + said->text + "' is not read, only " + units.front().first +
                          "; give the tables in that unit");
}

/// The letters of the joints, in their order; a letter that is there twice is of the first joint.
std::vector<std::string> jointLetters(const ConfigSection& traj) {
  const TextLine& coordinates = traj.values.need("COORDINATES");
  std::vector<std::string> letters;
  for (const char c : capitalsWithoutBlanks(coordinates.text))
    letters.push_back(jointOfAxis(std::string(1, c), coordinates.place));
  return letters;
}

/// With a table BACKLASH is not looked at, without one half of it is added in each direction (control.c).
AxisTable jointTable(const KeyedValues& joint, const std::string& letter, double unit,
                     const std::filesystem::path& folder) {
  if (const TextLine* file = joint.find("COMP_FILE")) {
    const std::filesystem::path path = folder / file->text;
    if (!std::filesystem::exists(path))
      refuse(file->place, "COMP_FILE: there is no file '" + path.string() + "'");
    const bool nominalLess = joint.number("COMP_FILE_TYPE", 0.0) == 0.0;
    const TextTable table = compTriplets(path);
    if (!table.rows.empty()) {
      const std::vector<double> nominal = table.rising("nominal", kMostCompEntries);
      const auto curve = [&](const char* column) {
        std::vector<double> added = table.numbers(column);
        for (std::size_t i = 0; i < added.size() && nominalLess; ++i) added[i] = nominal[i] - added[i];
        return Curve(inUnit(nominal, unit), inUnit(added, unit));
      };
      return {letter, letter, curve("forward"), curve("reverse")};
    }
  }
  const double backlash = unit * joint.number("BACKLASH", 0.0);
  return reversal(letter, 0.5 * backlash, -0.5 * backlash);
}

}  // namespace

std::unique_ptr<Interpreter> interpretLinuxcnc(const std::filesystem::path& folder) {
  const std::filesystem::path ini = folder / "machine.ini";
  const std::vector<ConfigSection> sections = configSections(ini);
  const ConfigSection* traj = findSection(sections, "TRAJ");
  if (traj == nullptr || !traj->values.has("COORDINATES"))
    refuse(
        {ini, 0},
        "[TRAJ] COORDINATES is missing: which joint moves which axis is not known; e.g. COORDINATES = XYZ");
  const std::vector<std::string> letters = jointLetters(*traj);
  const double linear = trajUnit(*traj, "LINEAR_UNITS", {{"mm", kMillimetre}, {"metric", kMillimetre}}),
               angular = trajUnit(*traj, "ANGULAR_UNITS", {{"degree", kDegree}, {"deg", kDegree}});
  std::vector<AxisTable> tables;
  for (const ConfigSection& section : sections) {
    if (!startsWith(section.name, "JOINT_")) continue;
    const int joint = tableInteger(section.name.substr(6), section.values.whole(), "number of the joint", 0,
                                   kMostLinuxcncJoints - 1);
    if (joint >= static_cast<int>(letters.size()))
      refuse(section.values.whole(), "[" + section.name + "]: COORDINATES names " +
                                         std::to_string(letters.size()) + " joints, numbered from 0");
    const std::string& letter = letters[joint];
    if (std::find(letters.begin(), letters.begin() + joint, letter) != letters.begin() + joint) continue;
    const TextLine* type = section.values.find("TYPE");
    const double unit = type != nullptr && type->text == "ANGULAR" ? angular : linear;
    tables.push_back(jointTable(section.values, letter, unit, folder));
  }
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
