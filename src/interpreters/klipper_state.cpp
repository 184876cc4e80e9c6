// Klipper: klippy/extras/skew_correction.py, bed_mesh.py, z_thermal_adjust.py, axis_twist_compensation.py,
// docs/Skew_Correction.md, docs/Bed_Mesh.md (no profile is loaded by itself).
#include "interpreters/klipper_state.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/text.h"

namespace mm {
namespace {

constexpr double kHuge = 1e9, kColdest = -273.15;

/// tan of the skew from the diagonals AC, BD and the side AD of a parallelogram (calc_skew_factor).
double skewFactor(double ac, double bd, double ad) {
  const double side = std::sqrt(2.0 * ac * ac + 2.0 * bd * bd - 4.0 * ad * ad) / 2.0;
  return std::tan(std::asin((ac * ac - side * side - ad * ad) / (2.0 * side * ad)));
}

double configNumber(const ConfigSection& section, const char* key, double lower, double upper,
                    std::optional<double> missing = std::nullopt) {
  const ConfigEntry* entry = section.find(key);
  if (entry == nullptr && missing) return *missing;
  const ConfigEntry& found = section.need(key);
  return tableNumber(found.value, found.place, key, lower, upper);
}

/// The points of a profile, a row a line.
std::vector<std::vector<double>> meshPoints(const ConfigSection& section) {
  const ConfigEntry& entry = section.need("points");
  std::vector<std::vector<double>> rows;
  FilePlace place = entry.place;
  for (const std::string& line : partsBetween(entry.value, '\n')) {
    if (!line.empty()) {
      rows.emplace_back();
      for (const std::string& cell : partsBetween(line, ','))
        rows.back().push_back(tableNumber(cell, place, "points"));
    }
    ++place.line;
  }
  return rows;
}

MeshProfile meshProfile(const ConfigSection& section) {
  MeshProfile profile;
  const auto count = [&](const char* key, int lower) {
    const ConfigEntry& entry = section.need(key);
    return tableInteger(entry.value, entry.place, key, lower, 1000);
  };
  profile.points = meshPoints(section);
  const auto columns = static_cast<std::size_t>(count("x_count", 2)),
             rows = static_cast<std::size_t>(count("y_count", 2));
  if (profile.points.size() != rows)
    refuse(section.need("points").place,
           "points: " + std::to_string(profile.points.size()) + " rows, y_count is " + std::to_string(rows));
  for (const auto& row : profile.points)
    if (row.size() != columns)
      refuse(section.need("points").place, "points: a row of " + std::to_string(row.size()) +
                                               " heights, x_count is " + std::to_string(columns));
  profile.minX = configNumber(section, "min_x", -kHuge, kHuge);
  profile.maxX = configNumber(section, "max_x", -kHuge, kHuge);
  profile.minY = configNumber(section, "min_y", -kHuge, kHuge);
  profile.maxY = configNumber(section, "max_y", -kHuge, kHuge);
  if (!(profile.maxX > profile.minX)) refuse(section.need("max_x").place, "max_x is not above min_x");
  if (!(profile.maxY > profile.minY)) refuse(section.need("max_y").place, "max_y is not above min_y");
  profile.betweenX = count("mesh_x_pps", 0);
  profile.betweenY = count("mesh_y_pps", 0);
  const ConfigEntry& algorithm = section.need("algo");
  if (algorithm.value == "bicubic")
    profile.algorithm = MeshAlgorithm::kBicubic;
  else if (algorithm.value == "direct")
    profile.algorithm = MeshAlgorithm::kDirect;
  else if (algorithm.value != "lagrange")
    refuse(algorithm.place, "algo: '" + algorithm.value + "' is none of lagrange, bicubic, direct");
  profile.tension = configNumber(section, "tension", 0.0, 2.0, 0.2);
  return profile;
}

/// A command as Klipper's own ones are written: NAME KEY=value KEY=value.
struct KlipperCommand {
  std::string name;
  std::map<std::string, std::string> parameters;
  FilePlace place;

  const std::string* find(const std::string& key) const {
    const auto found = parameters.find(key);
    return found == parameters.end() ? nullptr : &found->second;
  }
};

KlipperCommand klipperCommand(const std::string& text, const FilePlace& place) {
  KlipperCommand command{"", {}, place};
  for (const std::string& word : wordsBetweenBlanks(text.substr(0, text.find(';')))) {
    const std::size_t equals = word.find('=');
    if (command.name.empty())
      command.name = capitals(word);
    else if (equals != std::string::npos)
      command.parameters[capitals(word.substr(0, equals))] =
          trim(std::string_view(word).substr(equals + 1), "\"");
  }
  return command;
}

/// Reads the configuration, then runs commands.
class KlipperReader {
 public:
  explicit KlipperReader(const std::filesystem::path& folder)
      : file_(folder / "printer.cfg"), sections_(configSections(file_, ConfigStyle::kKlipper)) {
    state_.fadeEnd = std::numeric_limits<double>::infinity();
    for (const ConfigSection& section : sections_) readSection(section);
    for (const ConfigSection& section : sections_)
      if (startsWith(section.name, "delayed_gcode ") &&
          configNumber(section, "initial_duration", 0.0, kHuge, 0.0) > 0.0)
        runGcode(section, 0);
    const std::filesystem::path start = folder / "start.gcode";
    if (!std::filesystem::exists(start)) return;
    for (const TextLine& line : textLines(start)) run(klipperCommand(line.text, line.place), 0);
  }
  KlipperState take() { return std::move(state_); }

 private:
  void readSection(const ConfigSection& section) {
    if (startsWith(section.name, "skew_correction ")) {
      KlipperSkew& skew = profiles_[section.name.substr(16)];
      skew = {configNumber(section, "xy_skew", -kHuge, kHuge),
              configNumber(section, "xz_skew", -kHuge, kHuge),
              configNumber(section, "yz_skew", -kHuge, kHuge)};
    } else if (section.name == "z_thermal_adjust") {
      state_.thermal.emplace();
      state_.thermal->coefficient = configNumber(section, "temp_coeff", -1.0, 1.0, 0.0);
      state_.thermal->most = configNumber(section, "max_z_adjustment", -kHuge, kHuge, state_.thermal->most);
    } else if (section.name == "axis_twist_compensation") {
      // it corrects what the probe reads, not where the motors go
      for (const char* key : {"z_compensations", "zy_compensations"})
        if (const ConfigEntry* entry = section.find(key))
          for (const std::string& cell : partsBetween(entry->value, ','))
            tableNumber(cell, entry->place, key);
    }
  }

  void runGcode(const ConfigSection& section, int depth) {
    const ConfigEntry& entry = section.need("gcode");
    FilePlace place = entry.place;
    for (const std::string& line : partsBetween(entry.value, '\n')) {
      run(klipperCommand(line, place), depth);
      ++place.line;
    }
  }

  void run(const KlipperCommand& command, int depth) {
    constexpr int kDeepest = 10;
    if (depth > kDeepest) refuse(command.place, command.name + ": macros call each other without an end");
    if (command.name == "SET_SKEW") return setSkew(command);
    if (command.name == "SKEW_PROFILE") return loadSkew(command);
    if (command.name == "BED_MESH_PROFILE") return loadMesh(command);
    if (command.name == "SET_Z_THERMAL_ADJUST") return setThermal(command);
    if (command.name == "BED_MESH_CLEAR") {
      state_.mesh.reset();
      state_.fadeTarget = 0.0;
    }
    for (const ConfigSection& section : sections_)
      if (capitals(section.name) == "GCODE_MACRO " + command.name) runGcode(section, depth + 1);
  }

  void needSection(const char* name, const KlipperCommand& command) const {
    if (findSection(sections_, name) == nullptr)
      refuse(command.place,
             command.name + ": is unknown to Klipper without [" + name + "] in " + file_.string());
  }

  void setSkew(const KlipperCommand& command) {
    needSection("skew_correction", command);
    if (const std::string* clear = command.find("CLEAR"))
      if (tableInteger(*clear, command.place, "SET_SKEW CLEAR", -1000000, 1000000) != 0) {
        state_.skew = {};
        return;
      }
    const std::pair<const char*, double*> planes[] = {
        {"XY", &state_.skew.xy}, {"XZ", &state_.skew.xz}, {"YZ", &state_.skew.yz}};
    for (const auto& [plane, factor] : planes) {
      const std::string* text = command.find(plane);
      if (text == nullptr) continue;
      const std::string field = std::string("SET_SKEW ") + plane;
      const std::vector<std::string> lengths = partsBetween(*text, ',');
      if (lengths.size() != 3)
        refuse(command.place, field + ": '" + *text + "' is not three lengths AC,BD,AD");
      *factor = skewFactor(tableNumber(lengths[0], command.place, field),
                           tableNumber(lengths[1], command.place, field),
                           tableNumber(lengths[2], command.place, field));
      if (!std::isfinite(*factor))
        refuse(command.place, field + ": " + *text + " are no sides of a parallelogram");
    }
  }

  void loadSkew(const KlipperCommand& command) {
    needSection("skew_correction", command);
    const std::string* name = command.find("LOAD");
    if (name == nullptr) return;
    const auto found = profiles_.find(*name);
    if (found == profiles_.end())
      refuse(command.place, "SKEW_PROFILE LOAD: there is no [skew_correction " + *name + "]");
    state_.skew = found->second;
  }

  /// Klipper refuses a mesh that does not fit into the range of its fading (set_mesh).
  void loadMesh(const KlipperCommand& command) {
    needSection("bed_mesh", command);
    const std::string* name = command.find("LOAD");
    if (name == nullptr) return;
    const ConfigSection* profile = findSection(sections_, "bed_mesh " + *name);
    if (profile == nullptr)
      refuse(command.place, "BED_MESH_PROFILE LOAD: there is no [bed_mesh " + *name + "]");
    KlipperMesh mesh(meshProfile(*profile));
    const ConfigSection& section = *findSection(sections_, "bed_mesh");
    const double start = configNumber(section, "fade_start", -kHuge, kHuge, 1.0),
                 end = configNumber(section, "fade_end", -kHuge, kHuge, 0.0);
    state_.fadeTarget = 0.0;
    state_.fadeEnd = state_.fadeStart = std::numeric_limits<double>::infinity();
    if (end > start) {
      state_.fadeStart = start;
      state_.fadeEnd = end;
      state_.fadeTarget = configNumber(section, "fade_target", -kHuge, kHuge, mesh.average());
      const bool given = section.find("fade_target") != nullptr;
      if (given && state_.fadeTarget != 0.0 &&
          (state_.fadeTarget < mesh.lowest() || state_.fadeTarget > mesh.highest()))
        refuse(section.need("fade_target").place,
               "fade_target: " + std::to_string(state_.fadeTarget) + " is not within the mesh, " +
                   std::to_string(mesh.lowest()) + " to " + std::to_string(mesh.highest()));
      mesh.subtract(state_.fadeTarget);
      if (end - start <= std::max(std::abs(mesh.lowest()), std::abs(mesh.highest())))
        refuse(section.need("fade_end").place,
               "fade_end: the mesh is higher than the fade distance, " + std::to_string(end - start) + " mm");
    }
    state_.mesh = mesh;
  }

  void setThermal(const KlipperCommand& command) {
    needSection("z_thermal_adjust", command);
    const auto number = [&](const char* key, double lower, double upper) -> std::optional<double> {
      const std::string* text = command.find(key);
      if (text == nullptr) return std::nullopt;
      return tableNumber(*text, command.place, std::string("SET_Z_THERMAL_ADJUST ") + key, lower, upper);
    };
    if (const auto enable = number("ENABLE", 0.0, 1.0)) state_.thermal->enabled = *enable > 0.0;
    if (const auto coefficient = number("TEMP_COEFF", -1.0, 1.0)) state_.thermal->coefficient = *coefficient;
    if (const auto reference = number("REF_TEMP", kColdest, kHuge)) state_.thermal->reference = *reference;
  }

  std::filesystem::path file_;
  std::vector<ConfigSection> sections_;
  std::map<std::string, KlipperSkew> profiles_;
  KlipperState state_;
};

}  // namespace

KlipperState readKlipperState(const std::filesystem::path& folder) { return KlipperReader(folder).take(); }

}  // namespace mm
