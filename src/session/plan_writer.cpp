#include "session/plan_writer.h"

#include <cmath>
#include <sstream>

#include "base/units.h"
#include "machine/joint_units.h"
#include "session/plan_generators.h"

namespace mm {
namespace {

/// Always in quotes: a name such as `1` or `no` stays a name.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"";
}

std::string list(const Eigen::Vector3d& v) {
  std::ostringstream out;
  out.precision(12);
  out << "[" << v.x() << ", " << v.y() << ", " << v.z() << "]";
  return out.str();
}

std::string stylusList(const Artifact& artifact) {
  std::ostringstream out;
  out.precision(12);
  for (const Stylus& s : artifact.styli) {
    out << (out.tellp() > 0 ? ", " : "[") << "{name: " << quoted(s.name)
        << ", tip_radius_mm: " << s.tipRadius / kMillimetre;
    if (s.offset.allFinite()) out << ", offset_mm: " << list(s.offset / kMillimetre);
    out << (s.known ? "}" : ", offset: free}");
  }
  out << "]";
  return out.str();
}

}  // namespace

std::string placementsYaml(const Plan& plan) {
  if (plan.placements.empty()) return "";
  std::ostringstream out;
  out.precision(12);
  out << "placements:\n";
  for (const PlanPlacement& p : plan.placements)
    out << "  - {name: " << quoted(p.name) << ", turn_deg: " << p.turn / kDegree
        << ", about_mm: " << list(p.about / kMillimetre) << ", shift_mm: " << list(p.shift / kMillimetre)
        << "}\n";
  return out.str();
}

std::string moveYaml(const PlanMove& move, const Plan& plan, const Machine& machine) {
  std::ostringstream out;
  out.precision(12);
  const std::vector<std::string> keys = jointKeys(machine);
  out << "{";
  for (std::size_t j = 0; j < keys.size(); ++j)
    out << (j > 0 ? ", " : "") << keys[j] << ": "
        << move.position[j] / readingUnit(machine.joints()[j]).factor;
  if (move.feature >= 0) out << ", feature: " << quoted(plan.artifact.features[move.feature].name);
  if (move.kind == MoveKind::kTouch) {
    const auto tip = [&](const std::vector<double>& q) {
      return machine.nominal(q.data(), kNotMeasured).position;
    };
    out << ", approach: " << list((tip(move.target) - tip(move.position)).normalized());
  }
  if (move.kind == MoveKind::kDeviation) out << ", reference: " << quoted(machine.joints()[move.joint].name);
  if (move.kind == MoveKind::kPosition) out << ", reference: position";
  if (move.kind == MoveKind::kLength) out << ", reference: length";
  if (!plan.placements.empty())
    out << ", placement: " << quoted(plan.placements[static_cast<std::size_t>(move.placement)].name);
  if (move.feature >= 0 && !plan.artifact.styli.empty())
    out << ", stylus: " << quoted(plan.artifact.styli[static_cast<std::size_t>(move.stylus)].name);
  if (!move.setup.empty()) out << ", setup: " << quoted(move.setup);
  if (move.speed > 0.0) out << ", speed_mm_s: " << move.speed / kMillimetre;
  if (move.wait > 0.0) out << ", wait_s: " << move.wait;
  out << "}";
  return out.str();
}

std::string artifactYaml(const Artifact& artifact, int indent) {
  const std::string in(static_cast<std::size_t>(indent), ' ');
  std::ostringstream out;
  out.precision(12);
  out << in << "name: " << quoted(artifact.name) << "\n"
      << in << "pose: " << (artifact.poseKnown ? "known" : "free") << "\n";
  if (!artifact.serial.empty()) out << in << "serial: " << quoted(artifact.serial) << "\n";
  if (artifact.styli.empty())
    out << in << "probe: {tip_radius_mm: " << artifact.tipRadius / kMillimetre;
  else
    out << in << "probe: {styli: " << stylusList(artifact);
  if (artifact.repeatability > 0.0) out << ", repeatability_um: " << artifact.repeatability / kMicrometre;
  out << "}\n";
  if (artifact.expansion != 0.0) out << in << "expansion_per_K: " << artifact.expansion << "\n";
  if (!artifact.temperatureSensor.empty())
    out << in << "temperature_sensor: " << quoted(artifact.temperatureSensor) << "\n";
  for (const FeatureKind kind : {FeatureKind::kBall, FeatureKind::kPoint}) {
    const bool ball = kind == FeatureKind::kBall;
    const std::string place = ball ? "centre" : "position";
    bool first = true;
    for (const Feature& f : artifact.features) {
      if (f.kind != kind) continue;
      if (first) out << in << (ball ? "balls" : "points") << ":\n";
      first = false;
      out << in << "  - {name: " << quoted(f.name);
      if (f.position.allFinite()) out << ", " << place << "_mm: " << list(f.position / kMillimetre);
      if (!f.known) out << ", " << place << ": free";
      if (ball) out << ", radius_mm: " << f.radius / kMillimetre;
      if (ball && f.radiusStd > 0.0) out << ", radius_std_um: " << f.radiusStd / kMicrometre;
      if (f.positionStd > 0.0) out << ", " << place << "_std_um: " << f.positionStd / kMicrometre;
      out << "}\n";
    }
  }
  return out.str();
}

std::string planYaml(const Plan& plan, const Machine& machine) {
  std::ostringstream out;
  out.precision(12);
  out << "name: " << quoted(plan.name) << "\nprobe: " << (plan.laser ? "laser" : "touch") << "\n";
  if (!plan.artifact.features.empty()) out << "artifact:\n" << artifactYaml(plan.artifact, 2);
  out << "speeds: {rapid_mm_s: " << plan.rapid / kMillimetre
      << ", rapid_deg_s: " << plan.rapidRotary / kDegree << "}\n";
  out << placementsYaml(plan) << "moves:\n";
  for (const PlanMove& move : plan.moves) out << "  - " << moveYaml(move, plan, machine) << "\n";
  return out.str();
}

}  // namespace mm
