// LinuxCNC: src/emc/motion/usrmotintf.cc (usrmotLoadComp), command.c (EMCMOT_SET_JOINT_COMP), control.c
// (compute_screw_comp), src/emc/ini/inijoint.cc. Where a joint was homed its motor offset takes up what the
// table adds there; that constant is the joint's zero, and not counted here.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <optional>

#include "base/error.h"
#include "base/nearest_name.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr std::size_t kMostCompEntries = 256;  // EMCMOT_COMP_SIZE
constexpr int kMostLinuxcncJoints = 16;        // EMCMOT_MAX_JOINTS
constexpr double kMillimetresInInch = 25.4;

struct CompTable {
  std::vector<double> nominal, forward, reverse;  // machine units; what is added in each direction
};

/// A line that is no triplet ends the table, as sscanf ends LinuxCNC's loop.
CompTable readCompFile(const std::filesystem::path& file, int type) {
  CompTable table;
  std::optional<FilePlace> end;
  for (const TextLine& line : textLines(file)) {
    double nominal = 0.0, forward = 0.0, reverse = 0.0;
    if (std::sscanf(line.text.c_str(), "%lf %lf %lf", &nominal, &forward, &reverse) != 3) {
      if (!end) end = line.place;
      continue;
    }
    if (end)
      refuse(*end, "is no triplet of numbers, and LinuxCNC reads no further, but line " +
                       std::to_string(line.place.line) + " is one; take the line out");
    if (table.nominal.size() == kMostCompEntries)
      refuse(line.place, "entry " + std::to_string(kMostCompEntries + 1) + " of at most " +
                             std::to_string(kMostCompEntries) + " (too many compensation entries)");
    if (!table.nominal.empty() && nominal <= table.nominal.back())
      refuse(line.place, "nominal: " + wordsBetweenBlanks(line.text)[0] +
                             " is not above that of the line before (compensation values must increase)");
    table.nominal.push_back(nominal);
    table.forward.push_back(type == 0 ? nominal - forward : forward);
    table.reverse.push_back(type == 0 ? nominal - reverse : reverse);
  }
  return table;
}

double linearUnits(const ConfigSection* traj) {
  const ConfigEntry* entry = traj == nullptr ? nullptr : traj->find("LINEAR_UNITS");
  if (entry == nullptr) return kMillimetre;
  const std::string word = lower(entry->value);
  if (word == "mm" || word == "metric") return kMillimetre;
  if (word == "in" || word == "inch" || word == "imperial") return kMillimetresInInch * kMillimetre;
  return kMillimetre / tableNumber(entry->value, entry->place, "LINEAR_UNITS", 1e-6, 1e6);
}

double angularUnits(const ConfigSection* traj) {
  const ConfigEntry* entry = traj == nullptr ? nullptr : traj->find("ANGULAR_UNITS");
  if (entry == nullptr) return kDegree;
  const std::string word = lower(entry->value);
  if (word == "deg" || word == "degree") return kDegree;
  if (word == "grad" || word == "gon") return 0.9 * kDegree;
  if (word == "rad" || word == "radian") return 1.0;
  return kDegree / tableNumber(entry->value, entry->place, "ANGULAR_UNITS", 1e-6, 1e6);
}

/// The letters of the joints, in their order; a letter that is there twice is of the first joint.
std::vector<std::string> jointLetters(const std::vector<ConfigSection>& sections,
                                      const std::filesystem::path& ini) {
  const ConfigSection* traj = findSection(sections, "TRAJ");
  const ConfigSection* kins = findSection(sections, "KINS");
  std::string text;
  FilePlace place{ini, 0};
  if (const ConfigEntry* entry = traj == nullptr ? nullptr : traj->find("COORDINATES")) {
    text = entry->value;
    place = entry->place;
  } else if (const ConfigEntry* kinematics = kins == nullptr ? nullptr : kins->find("KINEMATICS")) {
    place = kinematics->place;
    const std::string value = lower(kinematics->value);
    const std::size_t at = value.find("coordinates=");
    if (at != std::string::npos) text = value.substr(at + 12, value.find_first_of(" \t", at) - at - 12);
  }
  std::vector<std::string> letters;
  for (const char c : lower(text))
    if (kBlanks.find(c) == std::string_view::npos) letters.push_back(jointOfAxis(std::string(1, c), place));
  if (letters.empty())
    refuse(
        place,
        "[TRAJ] COORDINATES is missing: which joint moves which axis is not known; e.g. COORDINATES = XYZ");
  return letters;
}

bool isAngular(const ConfigSection& joint) {
  const ConfigEntry* type = joint.find("TYPE");
  if (type == nullptr || type->value == "LINEAR") return false;
  if (type->value != "ANGULAR")
    refuse(type->place, "TYPE: '" + type->value + "' is neither LINEAR nor ANGULAR");
  return true;
}

/// With a table BACKLASH is not looked at, without one half of it is added in each direction (control.c).
AxisTable jointTable(const ConfigSection& section, const std::string& letter, double unit,
                     const std::filesystem::path& folder) {
  if (const ConfigEntry* file = section.find("COMP_FILE")) {
    int type = 0;
    if (const ConfigEntry* entry = section.find("COMP_FILE_TYPE"))
      type = tableInteger(entry->value, entry->place, "COMP_FILE_TYPE", std::numeric_limits<int>::min(),
                          std::numeric_limits<int>::max());
    const std::filesystem::path path = folder / file->value;
    if (!std::filesystem::exists(path))
      refuse(file->place, "COMP_FILE: there is no file '" + path.string() + "'");
    CompTable table = readCompFile(path, type);
    if (!table.nominal.empty()) {
      for (std::vector<double>* values : {&table.nominal, &table.forward, &table.reverse})
        for (double& value : *values) value *= unit;
      return {letter, letter, {table.nominal, table.forward}, {table.nominal, table.reverse}};
    }
  }
  double backlash = 0.0;
  if (const ConfigEntry* entry = section.find("BACKLASH"))
    backlash = unit * tableNumber(entry->value, entry->place, "BACKLASH");
  return {letter, letter, Curve(0.5 * backlash), Curve(-0.5 * backlash)};
}

}  // namespace

std::unique_ptr<Interpreter> interpretLinuxcnc(const std::filesystem::path& folder) {
  const std::filesystem::path ini = folder / "machine.ini";
  const std::vector<ConfigSection> sections = configSections(ini, ConfigStyle::kIni);
  const std::vector<std::string> letters = jointLetters(sections, ini);
  const ConfigSection* traj = findSection(sections, "TRAJ");
  std::vector<AxisTable> tables;
  for (const ConfigSection& section : sections) {
    if (!startsWith(section.name, "JOINT_")) continue;
    const int joint = tableInteger(section.name.substr(6), section.place, "number of the joint", 0,
                                   kMostLinuxcncJoints - 1);
    if (joint >= static_cast<int>(letters.size()))
      refuse(section.place, "[" + section.name + "]: COORDINATES names " + std::to_string(letters.size()) +
                                " joints, numbered from 0");
    const std::string& letter = letters[joint];
    if (std::find(letters.begin(), letters.begin() + joint, letter) != letters.begin() + joint) continue;
    const double unit = isAngular(section) ? angularUnits(traj) : linearUnits(traj);
    tables.push_back(jointTable(section, letter, unit, folder));
  }
  return std::make_unique<TableSum>(std::move(tables));
}

}  // namespace mm
