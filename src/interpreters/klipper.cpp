// Klipper: klippy/extras/skew_correction.py, bed_mesh.py, z_thermal_adjust.py, docs/Skew_Correction.md,
// docs/Bed_Mesh.md (no profile is loaded by itself). A position goes through the skew, then the thermal
// adjustment of z, then the mesh (each registers its set_move_transform before the one of the step before:
// klippy:ready, klippy:connect, reading of the configuration).
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "base/units.h"
#include "interpreters/table_sum.h"
#include "interpreters/targets.h"

namespace mm {
namespace {

constexpr double kHuge = 1e9, kAbsoluteZero = -273.15;

/// tan of the skew from the diagonals AC, BD and the side AD of a parallelogram (calc_skew_factor).
double skewFactor(double ac, double bd, double ad) {
  const double side = std::sqrt(2.0 * ac * ac + 2.0 * bd * bd - 4.0 * ad * ad) / 2.0;
  return std::tan(std::asin((ac * ac - side * side - ad * ad) / (2.0 * side * ad)));
}

/// Equal steps along one axis of a mesh, mm.
struct MeshAxis {
  double first = 0.0, step = 0.0;
  int count = 0;

  std::vector<double> positions() const {
    std::vector<double> positions;
    for (int i = 0; i < count; ++i) positions.push_back(first + i * step);
    return positions;
  }
  /// The point before a place, and the share of the way to the next; the ends are held.
  std::pair<int, double> place(double at) const {
    const int i = std::clamp(static_cast<int>(std::floor((at - first) / step)), 0, count - 2);
    return {i, std::clamp((at - (first + step * i)) / step, 0.0, 1.0)};
  }
};

/// Heights of a bed mesh, mm: straight lines between its points, the border beyond.
struct KlipperMesh {
  MeshAxis alongX, alongY;
  std::vector<std::vector<double>> rows;  // of y

  double at(double x, double y) const {
    const auto [i, tx] = alongX.place(x);
    const auto [k, ty] = alongY.place(y);
    const auto along = [i = i, tx = tx](const std::vector<double>& row) {
      return (1.0 - tx) * row[i] + tx * row[i + 1];
    };
    return (1.0 - ty) * along(rows[k]) + ty * along(rows[k + 1]);
  }
};

/// What Klipper does to positions after the commands of its start, mm and degC.
struct KlipperState {
  double xy = 0.0, xz = 0.0, yz = 0.0;  // tangents
  bool adjusts = false;                 // z by a temperature
  double coefficient = 0.0, mostAdjusted = 99999999.0;
  std::optional<double> reference;
  std::optional<KlipperMesh> mesh;
};

class KlipperInterpreter : public Interpreter {
 public:
  explicit KlipperInterpreter(KlipperState state) : state_(std::move(state)) {}

  std::map<std::string, double> motors(const CommandedState& command) const override {
    const KlipperState& s = state_;
    const bool skews = s.xy != 0.0 || s.xz != 0.0 || s.yz != 0.0;
    if (!skews && !s.adjusts && !s.mesh) return command.position;
    double x = commanded(command, "x") / kMillimetre, y = commanded(command, "y") / kMillimetre,
           z = commanded(command, "z") / kMillimetre;
    x = x - y * s.xy - z * (s.xz - s.xy * s.yz);
    y = y - z * s.yz;
    z += adjustment(command);
    if (s.mesh) z += s.mesh->at(x, y);
    std::map<std::string, double> motors = command.position;
    motors["x"] = x * kMillimetre;
    motors["y"] = y * kMillimetre;
    motors["z"] = z * kMillimetre;
    return motors;
  }

  JointPoints points() const override {
    JointPoints points;
    if (state_.xy != 0.0 || state_.xz != 0.0) points["x"];
    if (state_.yz != 0.0) points["y"];
    if (state_.adjusts || state_.mesh) points["z"];
    if (!state_.mesh) return points;
    addPoints("x", inUnit(state_.mesh->alongX.positions(), kMillimetre), points);
    addPoints("y", inUnit(state_.mesh->alongY.positions(), kMillimetre), points);
    return points;
  }

 private:
  /// Steps of the z motor are not counted: Klipper leaves changes below one of them out.
  double adjustment(const CommandedState& command) const {
    if (!state_.adjusts) return 0.0;
    const auto found = command.temperature.find("z_thermal_adjust");
    if (found == command.temperature.end())
      throw InputError("z_thermal_adjust needs a temperature of that name, which the command does not have");
    const double most = std::abs(state_.mostAdjusted);
    return std::clamp(-state_.coefficient * (found->second - *state_.reference), -most, most);
  }

  KlipperState state_;
};

MeshAxis meshAxis(const KeyedValues& profile, const std::string& axis) {
  const int count = profile.integer(axis + "_count", 2, 1000);
  const double least = profile.number("min_" + axis, {}, -kHuge, kHuge),
               most = profile.number("max_" + axis, {}, -kHuge, kHuge);
  if (!(most > least)) refuse(profile.place("max_" + axis), "max_" + axis + " is not above min_" + axis);
  return {least, (most - least) / (count - 1), count};
}

/// A profile as SAVE_CONFIG writes it where nothing is filled in between the points that were probed.
KlipperMesh meshOf(const ConfigSection& profile, const KeyedValues& settings) {
  const TextLine& algorithm = profile.values.need("algo");
  if (algorithm.text != "direct")
    refuse(algorithm.place, "algo: '" + algorithm.text + "' is not read, only direct (mesh_pps: 0, 0)");
  if (settings.number("fade_end", 0.0) > 0.0)
    refuse(settings.place("fade_end"), "fade_end: a mesh that fades is not read; take fade_end out");
  KlipperMesh mesh;
  mesh.alongX = meshAxis(profile.values, "x");
  mesh.alongY = meshAxis(profile.values, "y");
  const FilePlace& place = profile.values.need("points").place;
  const auto points = profile.below.find("points");
  for (const TextLine& line : points == profile.below.end() ? std::vector<TextLine>{} : points->second) {
    mesh.rows.emplace_back();
    for (const std::string& cell : partsBetween(line.text, ','))
      mesh.rows.back().push_back(tableNumber(cell, line.place, "points"));
    if (static_cast<int>(mesh.rows.back().size()) != mesh.alongX.count)
      refuse(line.place, "points: a row of " + std::to_string(mesh.rows.back().size()) +
                             " heights, x_count is " + std::to_string(mesh.alongX.count));
  }
  if (static_cast<int>(mesh.rows.size()) != mesh.alongY.count)
    refuse(place, "points: " + std::to_string(mesh.rows.size()) + " rows, y_count is " +
                      std::to_string(mesh.alongY.count));
  return mesh;
}

/// Reads the configuration, then runs the commands of the start.
class KlipperReader {
 public:
  explicit KlipperReader(const std::filesystem::path& folder)
      : file_(folder / "printer.cfg"), sections_(configSections(file_)) {
    for (const TextLine& line : textLines(file_))
      for (const std::string& name :
           wordsBetweenBlanks(capitals(line.text.substr(0, line.text.find_first_of("#;"))))) {
        if (!isKnown(name)) continue;
        refuse(line.place, name +
                               ": commands of compensation count in start.gcode alone; write there what runs "
                               "at the start, and take it out here");
      }
    const ConfigSection* heat = findSection(sections_, "z_thermal_adjust");
    if (heat != nullptr) {
      state_.coefficient = heat->values.number("temp_coeff", 0.0, -1.0, 1.0);
      state_.mostAdjusted = heat->values.number("max_z_adjustment", state_.mostAdjusted);
      state_.adjusts = state_.coefficient != 0.0;
    }
    if (const std::filesystem::path start = folder / "start.gcode"; std::filesystem::exists(start))
      for (const TextLine& line : textLines(start))
        if (isKnown(commandName(line.text))) run(line);
    if (state_.adjusts && !state_.reference)
      refuse(heat->values.whole(),
             "z_thermal_adjust: the temperature at which z was homed is not known; "
             "SET_Z_THERMAL_ADJUST REF_TEMP in start.gcode sets it");
  }
  KlipperState take() { return std::move(state_); }

 private:
  static std::string commandName(const std::string& text) {
    const std::vector<std::string> words = wordsBetweenBlanks(capitals(text));
    return words.empty() ? "" : words[0];
  }
  static std::string unquoted(std::string value) {
    value.erase(std::remove(value.begin(), value.end(), '"'), value.end());
    return value;
  }
  static bool isKnown(const std::string& name) {
    return name == "SET_SKEW" || name == "SKEW_PROFILE" || name == "BED_MESH_PROFILE" ||
           name == "BED_MESH_CLEAR" || name == "SET_Z_THERMAL_ADJUST";
  }

  /// NAME KEY=value KEY=value.
  void run(const TextLine& line) {
    const std::string name = commandName(line.text);
    KeyedValues said(line.place);
    for (const std::string& word : wordsBetweenBlanks(line.text.substr(0, line.text.find(';'))))
      if (const std::size_t equals = word.find('='); equals != std::string::npos)
        said.set(capitals(word.substr(0, equals)), unquoted(word.substr(equals + 1)), line.place);
    if (name == "SET_SKEW") setSkew(said);
    if (name == "SKEW_PROFILE") loadSkew(said);
    if (name == "BED_MESH_PROFILE")
      if (const ConfigSection* profile = loaded("bed_mesh", said))
        state_.mesh = meshOf(*profile, findSection(sections_, "bed_mesh")->values);
    if (name == "BED_MESH_CLEAR") state_.mesh.reset();
    if (name == "SET_Z_THERMAL_ADJUST") setThermal(said);
  }

  const ConfigSection& sectionFor(const std::string& name, const KeyedValues& said) const {
    const ConfigSection* section = findSection(sections_, name);
    if (section == nullptr) refuse(said.whole(), "there is no [" + name + "] in " + file_.string());
    return *section;
  }
  /// The profile that LOAD= names; null: it names none.
  const ConfigSection* loaded(const std::string& kind, const KeyedValues& said) const {
    sectionFor(kind, said);
    return said.has("LOAD") ? &sectionFor(kind + " " + said.need("LOAD").text, said) : nullptr;
  }

  void setSkew(const KeyedValues& said) {
    sectionFor("skew_correction", said);
    if (said.integer("CLEAR", -1000000, 1000000, 0) != 0) {
      state_.xy = state_.xz = state_.yz = 0.0;
      return;  // whatever stands beside it
    }
    const std::pair<const char*, double*> planes[] = {
        {"XY", &state_.xy}, {"XZ", &state_.xz}, {"YZ", &state_.yz}};
    for (const auto& [plane, factor] : planes) {
      if (!said.has(plane)) continue;
      const std::string field = std::string("SET_SKEW ") + plane, text = said.need(plane).text;
      const std::vector<std::string> lengths = partsBetween(text, ',');
      if (lengths.size() != 3) refuse(said.whole(), field + ": '" + text + "' is not three lengths AC,BD,AD");
      const auto length = [&](std::size_t i) { return tableNumber(lengths[i], said.whole(), field); };
      *factor = skewFactor(length(0), length(1), length(2));
      if (!std::isfinite(*factor))
        refuse(said.whole(), field + ": " + text + " are no sides of a parallelogram");
    }
  }

  void loadSkew(const KeyedValues& said) {
    const ConfigSection* profile = loaded("skew_correction", said);
    if (profile == nullptr) return;
    state_.xy = profile->values.number("xy_skew");
    state_.xz = profile->values.number("xz_skew");
    state_.yz = profile->values.number("yz_skew");
  }

  void setThermal(const KeyedValues& said) {
    sectionFor("z_thermal_adjust", said);
    if (said.has("TEMP_COEFF"))
      refuse(said.whole(),
             "SET_Z_THERMAL_ADJUST TEMP_COEFF: is not read; write temp_coeff into " + file_.string());
    state_.adjusts = state_.coefficient != 0.0 && said.flag("ENABLE", state_.adjusts);
    if (said.has("REF_TEMP")) state_.reference = said.number("REF_TEMP", {}, kAbsoluteZero, kHuge);
  }

  std::filesystem::path file_;
  std::vector<ConfigSection> sections_;
  KlipperState state_;
};

}  // namespace

std::unique_ptr<Interpreter> interpretKlipper(const std::filesystem::path& folder) {
  return std::make_unique<KlipperInterpreter>(KlipperReader(folder).take());
}

}  // namespace mm
