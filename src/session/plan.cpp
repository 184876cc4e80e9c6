#include "session/plan.h"

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/read_file.h"
#include "base/text.h"
#include "base/units.h"
#include "base/yaml_mapping.h"
#include "session/artifact_file.h"
#include "session/plan_builder.h"
#include "session/plan_generators.h"
#include "session/trial_block.h"

namespace mm {
namespace {

void readArtifact(const YamlMapping& root, const std::filesystem::path& folder, Plan& plan) {
  if (!root.has("artifact")) return;  // interferometer runs need none
  const YAML::Node node = root.node("artifact");
  if (!node.IsScalar()) {
    plan.artifact = parseArtifact(
        YAML::Dump(node), plan.source + " (artifact at line " + std::to_string(root.line("artifact")) + ")");
    return;
  }
  const std::filesystem::path file = node.Scalar();
  // Plans also come in goals of actions: no other file is read, whose lines a message would then tell.
  if (file.extension() != ".yaml" && file.extension() != ".yml")
    throw InputError(plan.source + ":" + std::to_string(root.line("artifact")) + ": artifact '" +
                     file.string() + "' is not an artifact file, whose name ends in .yaml");
  plan.artifact = loadArtifact(file.is_absolute() ? file : folder / file);
}

/// A number that a section of a plan may give.
struct Setting {
  const char* key;
  double factor, lower, upper;  // bounds as written
  double& value;                // SI
};

void readNumbers(const YamlMapping& root, const std::string& section, const std::vector<Setting>& settings) {
  if (!root.has(section)) return;
  std::vector<std::string> keys;
  for (const Setting& s : settings) keys.emplace_back(s.key);
  const YamlMapping map(root.node(section), root.source(), section, keys);
  for (const Setting& s : settings)
    if (map.has(s.key)) s.value = map.number(s.key, s.factor, s.lower, s.upper);
}

void readSettings(const YamlMapping& root, Plan& plan, PlanBuilder& builder) {
  const Machine& machine = builder.machine();
  readNumbers(root, "speeds",
              {{"rapid_mm_s", kMillimetre, 1e-3, 1e4, plan.rapid},
               {"rapid_deg_s", kDegree, 1e-3, 1e4, plan.rapidRotary},
               {"approach_mm_s", kMillimetre, 1e-3, 1e4, builder.approachSpeed}});
  readNumbers(root, "approach",
              {{"distance_mm", kMillimetre, 0.01, 1e3, builder.approachDistance},
               {"overtravel_mm", kMillimetre, 0.01, 1e3, builder.overtravel},
               {"overrun_mm", kMillimetre, 0.0, 1e3, builder.overrun},
               {"overrun_deg", kDegree, 0.0, 90.0, builder.overrunRotary}});
  if (root.has("clearance")) {
    const YamlMapping clearance(root.node("clearance"), plan.source, "clearance", jointKeys(machine));
    const std::vector<double> readings =
        readingsOf(clearance, machine, std::vector<double>(machine.joints().size(), kNotMeasured));
    for (int j = 0; j < machine.jointCount(); ++j)
      if (!std::isnan(readings[j])) builder.clearance[j] = readings[j];
  }
  if (root.has("probe")) {
    const std::string probe = root.text("probe");
    if (probe != "touch" && probe != "laser")
      root.fail("probe", "is '" + probe + "', but must be touch or laser");
    plan.laser = probe == "laser";
  }
}

void readPlacements(const YamlMapping& root, Plan& plan) {
  if (!root.has("placements")) return;
  const YAML::Node list = root.node("placements");
  if (!list.IsSequence() || list.size() == 0) root.fail("placements", "must be a list of one or more");
  for (const YAML::Node& node : list) {
    const YamlMapping m(node, plan.source, "a placement", {"name", "turn_deg", "about_mm", "shift_mm"});
    PlanPlacement placement;
    placement.name = m.text("name");
    if (m.has("turn_deg")) placement.turn = m.number("turn_deg", kDegree, -360.0, 360.0);
    if (m.has("about_mm")) placement.about = m.vector("about_mm", kMillimetre);
    if (m.has("shift_mm")) placement.shift = m.vector("shift_mm", kMillimetre);
    for (const PlanPlacement& other : plan.placements)
      if (other.name == placement.name)
        m.fail("name", "'" + placement.name + "' is used by another placement");
    plan.placements.push_back(std::move(placement));
  }
}

/// The styli of the plan's key `styli`: `all`, or names in the artifact's file; without it the first.
std::vector<int> readStyli(const YamlMapping& root, const Plan& plan) {
  if (!root.has("styli")) return {0};
  const std::vector<std::string> known = allNames(plan.artifact.styli);
  std::vector<int> styli;
  for (const std::string& name : root.texts("styli")) {
    const int at = plan.artifact.findStylus(name);
    if (at < 0 && name != "all")
      root.fail("styli", "names '" + name + "', which the artifact does not: it has " + listOf(known));
    for (int s = 0; s < static_cast<int>(known.size()); ++s)
      if (s == at || name == "all") styli.push_back(s);
  }
  if (styli.empty()) root.fail("styli", "is given, but the artifact names none (probe: styli)");
  return styli;
}

/// Index that a key names; -1 without it.
int indexIn(const YamlMapping& entry, const std::string& key, const std::vector<std::string>& names) {
  if (!entry.has(key)) return -1;
  const auto at = std::find(names.begin(), names.end(), entry.text(key));
  if (at == names.end())
    entry.fail(key, "is '" + entry.text(key) + "', which is not among the plan's: " + listOf(names));
  return static_cast<int>(at - names.begin());
}

/// `touch` and `postures` in every placement and with every stylus, unless an entry names its own.
template <typename Expand>
void everywhere(const YAML::Node& section, const Plan& plan, const std::vector<int>& styli,
                PlanBuilder& builder, const Expand& expand) {
  const std::vector<YAML::Node> entries = entriesOf(section);
  for (int p = 0; p < std::max(1, static_cast<int>(plan.placements.size())); ++p)
    for (const int s : styli)
      for (const YAML::Node& entry : entries) {
        if (entry.IsMap()) {
          const YamlMapping m = YamlMapping::written(entry, plan.source, "an entry", "");
          const int placement = indexIn(m, "placement", allNames(plan.placements));
          const int stylus = indexIn(m, "stylus", allNames(plan.artifact.styli));
          if ((placement >= 0 && placement != p) || (stylus >= 0 && stylus != s)) continue;
        }
        builder.stand(p, s);
        expand(entry, builder);
      }
}

/// A placement or a stylus that is named and never used was meant to be.
void checkUsed(const YamlMapping& root, const Plan& plan, const std::vector<int>& styli) {
  for (std::size_t p = 0; p < plan.placements.size(); ++p)
    if (std::none_of(plan.moves.begin(), plan.moves.end(), [&](const PlanMove& m) {
          return m.kind != MoveKind::kGo && m.placement == static_cast<int>(p);
        }))
      root.fail("placements", "names '" + plan.placements[p].name + "', in which nothing is measured");
  for (const int s : styli)
    if (root.has("styli") && std::none_of(plan.moves.begin(), plan.moves.end(), [&](const PlanMove& m) {
          return m.kind == MoveKind::kTouch && m.stylus == s;
        }))
      root.fail("styli", "names '" + plan.artifact.styli[static_cast<std::size_t>(s)].name +
                             "', with which nothing is touched");
}

std::vector<int> sidesOf(const YamlMapping& move, const Machine& machine) {
  std::vector<int> sides(machine.joints().size(), 0);
  if (!move.has("from")) return sides;
  const std::vector<std::string> names = allNames(machine.joints());
  const YamlMapping from(move.node("from"), move.source(), "from", names);
  for (std::size_t j = 0; j < names.size(); ++j) {
    if (!from.has(names[j])) continue;
    const double side = from.number(names[j], 1.0);
    if (side != 1.0 && side != -1.0) from.fail(names[j], "must be -1 (from below) or +1 (from above)");
    sides[j] = static_cast<int>(side);
  }
  return sides;
}

void readMove(const YAML::Node& node, const Plan& plan, PlanBuilder& builder) {
  const Machine& machine = builder.machine();
  std::vector<std::string> known = jointKeys(machine);
  for (const char* key :
       {"feature", "approach", "speed_mm_s", "wait_s", "from", "reference", "setup", "placement", "stylus"})
    known.push_back(key);
  const YamlMapping move(node, plan.source, "a move", known);
  builder.at(move.line(), "a move");
  builder.stand(std::max(0, indexIn(move, "placement", allNames(plan.placements))),
                std::max(0, indexIn(move, "stylus", allNames(plan.artifact.styli))));
  const std::vector<double> position = readingsOf(move, machine, builder.current());
  const std::vector<int> sides = sidesOf(move, machine);
  const double wait = move.has("wait_s") ? move.number("wait_s", 1.0, 0.0, 1e6) : 0.0;
  const double speed = move.has("speed_mm_s") ? move.number("speed_mm_s", kMillimetre, 1e-3, 1e4) : 0.0;
  const std::string what = move.has("reference") ? move.text("reference") : "";
  const std::string setup = move.has("setup") ? move.text("setup") : "";
  const bool length = what == "length";
  if (length && !move.has("feature")) move.fail("reference", "is length: name the 'feature' it begins at");
  if (!what.empty() && !length && move.has("feature"))
    move.fail("reference", "and 'feature' exclude each other, unless it is length");
  if (move.has("approach") && (length || !move.has("feature")))
    move.fail("approach", "needs a 'feature' to touch");
  if (move.has("setup") && !move.has("reference")) move.fail("setup", "is for a 'reference'");
  if (move.has("feature")) {
    const int feature = plan.artifact.findFeature(move.text("feature"));
    if (feature < 0)
      move.fail("feature",
                "'" + move.text("feature") + "' is not in the artifact '" + plan.artifact.name + "'");
    const Eigen::Vector3d approach =
        move.has("approach") ? move.vector("approach", 1.0) : Eigen::Vector3d::Zero();
    if (length) {
      builder.comeFrom(sides, position);
      builder.length(feature, position, speed, wait, setup);
    } else if (!plan.laser) {
      builder.touchFrom(feature, position, approach, speed > 0.0 ? speed : builder.approachSpeed, sides,
                        wait);
    } else {
      if (move.has("approach"))
        move.fail("approach", "is for a touch probe, but the plan's probe is a laser");
      builder.comeFrom(sides, position);
      builder.readLaser(feature, position, wait);
    }
    return;
  }
  builder.comeFrom(sides, position);
  if (!move.has("reference")) return builder.go(position, speed, wait);
  if (what == "position") return builder.reference(MoveKind::kPosition, -1, position, speed, wait, setup);
  const int joint = machine.findJoint(what);
  if (joint < 0)
    move.fail("reference", "is '" + what + "', but must be position, length or a joint of the machine");
  builder.reference(MoveKind::kDeviation, joint, position, speed, wait, setup);
}

constexpr int kDeepest = 8;  // lists in lists

/// A list of moves, and of groups of moves that are made several times.
void readMoves(const YamlMapping& of, const Plan& plan, PlanBuilder& builder, int depth) {
  const YAML::Node list = of.node("moves");
  if (!list.IsSequence() || list.size() == 0) of.fail("moves", "must be a list of one or more");
  if (depth > kDeepest) of.fail("moves", "are in groups more than " + std::to_string(kDeepest) + " deep");
  for (const YAML::Node& node : list) {
    if (!node.IsMap() || !node["moves"]) {
      readMove(node, plan, builder);
      continue;
    }
    const YamlMapping group(node, plan.source, "a group of moves", {"moves", "repeats"});
    const int repeats = group.has("repeats") ? group.count("repeats", 1) : 1;
    // The first time the joints come from elsewhere; each time after the second is as the second.
    std::size_t first = plan.moves.size();
    for (int i = 0; i < std::min(2, repeats); ++i) {
      first = plan.moves.size();
      readMoves(group, plan, builder, depth + 1);
    }
    builder.at(group.line(), "a group of moves");
    builder.again(first, std::max(0, repeats - 2));
  }
}

}  // namespace

Plan Plan::parse(const std::string& yaml, const std::string& source, const std::filesystem::path& folder,
                 const Machine& machine) {
  Plan plan;
  plan.source = source;
  plan.text = yaml;
  const YAML::Node node = YamlMapping::load(yaml, source);
  if (!node.IsMap())
    throw InputError(
        source + ":1: a plan is a mapping with 'artifact' and 'touch', 'postures', 'reference' or 'moves'");
  const YamlMapping root(node, source, "the plan",
                         {"name", "artifact", "probe", "speeds", "approach", "clearance", "touch", "postures",
                          "reference", "moves", "placements", "styli", "instrument"});
  plan.name = root.has("name") ? root.text("name") : std::filesystem::path(source).stem().string();
  readArtifact(root, folder, plan);
  readPlacements(root, plan);
  const std::vector<int> styli = readStyli(root, plan);
  PlanBuilder builder(plan, machine);
  readSettings(root, plan, builder);
  for (const std::string& key : root.keys()) {
    if (key == "touch" && plan.laser) root.fail(key, "needs a touch probe, but the plan's probe is a laser");
    if (key == "postures" && !plan.laser) root.fail(key, "needs 'probe: laser'");
    const YAML::Node section = root.node(key);
    if (key == "touch") everywhere(section, plan, styli, builder, expandTouch);
    if (key == "postures") everywhere(section, plan, styli, builder, expandPostures);
    if (key == "reference") expandReference(section, builder);
    if (key == "moves") readMoves(root, plan, builder, 1);
  }
  if (plan.measurements() == 0)
    throw InputError(source + ": the plan measures nothing; give touch, postures, reference or moves");
  checkUsed(root, plan, styli);
  return plan;
}

Eigen::Vector3d PlanPlacement::operator()(const Eigen::Vector3d& place) const {
  return Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * (place - about) + about + shift;
}

Eigen::Vector3d Plan::placeOf(int feature, int placement) const {
  const Eigen::Vector3d& place = artifact.features[static_cast<std::size_t>(feature)].position;
  return placements.empty() ? place : placements[static_cast<std::size_t>(placement)](place);
}

Eigen::Vector3d Plan::tipOf(const Machine& machine, const std::vector<double>& readings, int stylus) const {
  const ProbePose pose = machine.nominal(readings.data(), kNotMeasured);
  if (artifact.styli.empty()) return pose.position;
  return pose.position + pose.orientation * artifact.styli[static_cast<std::size_t>(stylus)].offset;
}

std::string Plan::standText(const PlanMove& move) const {
  std::vector<std::string> parts;
  std::string name;
  if (!placements.empty()) name = placements[static_cast<std::size_t>(move.placement)].name;
  if (const std::optional<TrialBlock> block = trialBlock(name)) {
    parts.push_back(
        format("state %c of the correction (block %d of %d)", block->state, block->number, block->of));
    name = block->placement;
  }
  if (!name.empty()) parts.push_back("placement '" + name + "'");
  if (artifact.styli.size() > 1)
    parts.push_back("stylus '" + artifact.styli[static_cast<std::size_t>(move.stylus)].name + "'");
  return joined(parts, ", ");
}

Plan Plan::load(const std::filesystem::path& file, const Machine& machine) {
  return parse(readWholeFile(file, "check the path of the plan"), file.string(), file.parent_path(), machine);
}

int Plan::measurements() const {
  return static_cast<int>(
      std::count_if(moves.begin(), moves.end(), [](const PlanMove& m) { return m.kind != MoveKind::kGo; }));
}

}  // namespace mm
