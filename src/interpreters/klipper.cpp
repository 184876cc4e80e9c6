// Klipper: klippy/extras/skew_correction.py, bed_mesh.py, z_thermal_adjust.py, docs/Skew_Correction.md,
// docs/Bed_Mesh.md (no profile is loaded by itself). A position goes through the skew, then the thermal
// adjustment of z, then the mesh (each registers its set_move_transform before the one of the step before:
// klippy:ready, klippy:connect, reading of the configuration).
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.h"
#include "base/format.h"
#include "base/grid_values.h"
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

/// Heights of a bed mesh, mm: straight lines between its points, the border beyond.
struct KlipperMesh {
  std::vector<std::vector<double>> at;  // positions of y and of x
  std::vector<double> heights;          // x fastest
};

/// What Klipper does to positions after the commands of its start, mm and degC.
struct KlipperState {
  double xy = 0.0, xz = 0.0, yz = 0.0;  // tangents
  bool adjusts = false;                 // z by a temperature
  double coefficient = 0.0, mostAdjusted = 99999999.0;
  std::optional<double> reference;
  std::optional<KlipperMesh> mesh;
};

/// Steps of the z motor are not counted: Klipper leaves changes below one of them out.
double thermalAdjustment(const KlipperState& state, const CommandedState& command) {
  if (!state.adjusts) return 0.0;
  const auto found = command.temperature.find("z_thermal_adjust");
  if (found == command.temperature.end())
    throw InputError("z_thermal_adjust needs a temperature of that name, which the command does not have");
  const double most = std::abs(state.mostAdjusted);
  return std::clamp(-state.coefficient * (found->second - *state.reference), -most, most);
}

JointPoints klipperPoints(const KlipperState& state) {
  JointPoints points = skewedJoints(state.xy, state.xz, state.yz);
  if (state.adjusts || state.mesh) points["z"];
  if (!state.mesh) return points;
  addPoints("y", inUnit(state.mesh->at[0], kMillimetre), points);
  addPoints("x", inUnit(state.mesh->at[1], kMillimetre), points);
  return points;
}

std::vector<double> meshPositions(const KeyedValues& profile, const std::string& axis) {
  const int count = profile.integer(axis + "_count", 2, 1000);
  const double least = profile.number("min_" + axis, {}, -kHuge, kHuge),
               most = profile.number("max_" + axis, {}, -kHuge, kHuge);
  if (!(most > least)) refuse(profile.place("max_" + axis), "max_" + axis + " is not above min_" + axis);
  const double step = (most - least) / (count - 1);
  std::vector<double> positions;
  for (int i = 0; i < count; ++i) positions.push_back(least + i * step);
  return positions;
}

/// A profile as SAVE_CONFIG writes it where nothing is filled in between the points that were probed.
KlipperMesh meshOf(const ConfigSection& profile, const KeyedValues& settings) {
  const TextLine& algorithm = profile.values.need("algo");
  if (algorithm.text != "direct")
    refuse(algorithm.place, "algo: '" + algorithm.text + "' is not read, only direct (mesh_pps: 0, 0)");
  if (settings.number("fade_end", 0.0) > 0.0)
    settings.refuse("fade_end", "a mesh that fades is not read; take fade_end out");
  const std::vector<double> alongX = meshPositions(profile.values, "x"),
                            alongY = meshPositions(profile.values, "y");
  KlipperMesh mesh{{alongY, alongX}, {}};
  profile.values.need("points");
  const auto points = profile.below.find("points");
  const std::vector<TextLine> rows = points == profile.below.end() ? std::vector<TextLine>{} : points->second;
  for (const TextLine& row : rows) {
    const std::vector<std::string> cells = partsBetween(row.text, ',');
    for (const std::string& cell : cells) mesh.heights.push_back(tableNumber(cell, row.place, "points"));
    if (cells.size() != alongX.size())
      refuse(row.place, format("points: a row of %zu heights, x_count is %zu", cells.size(), alongX.size()));
  }
  if (rows.size() != alongY.size())
    profile.values.refuse("points", format("%zu rows, y_count is %zu", rows.size(), alongY.size()));
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
  const KlipperState state = KlipperReader(folder).take();
  const auto move = [state](const CommandedState& command, Eigen::Vector3d& place) {
    const double x = place.x() / kMillimetre, y = place.y() / kMillimetre, z = place.z() / kMillimetre;
    const double skewedX = x - y * state.xy - z * (state.xz - state.xy * state.yz),
                 skewedY = y - z * state.yz;
    double height = z + thermalAdjustment(state, command);
    if (state.mesh) height += gridValue(gridCorners(state.mesh->at, {skewedY, skewedX}), state.mesh->heights);
    place = Eigen::Vector3d(skewedX, skewedY, height) * kMillimetre;
  };
  return std::make_unique<TableSum>(move, klipperPoints(state));
}

}  // namespace mm
