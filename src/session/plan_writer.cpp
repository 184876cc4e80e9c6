#include "session/plan_writer.h"

#include "base/format.h"
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

/// A key behind others, and its number.
std::string number(const char* key, double value) { return format(", %s: %.12g", key, value); }

/// A vector in mm, or without a unit.
std::string list(const Eigen::Vector3d& v) { return format("[%.12g, %.12g, %.12g]", v.x(), v.y(), v.z()); }

std::string stylusList(const Artifact& artifact) {
  std::string out;
  for (const Stylus& s : artifact.styli) {
    out += (out.empty() ? "{name: " : ", {name: ") + quoted(s.name) +
           number("tip_radius_mm", s.tipRadius / kMillimetre);
    if (s.offset.allFinite()) out += ", offset_mm: " + list(s.offset / kMillimetre);
    out += s.known ? "}" : ", offset: free}";
  }
  return "[" + out + "]";
}

}  // namespace

std::string placementsYaml(const Plan& plan) {
  if (plan.placements.empty()) return "";
  std::string out = "placements:\n";
  for (const PlanPlacement& p : plan.placements)
    out += "  - {name: " + quoted(p.name) + number("turn_deg", p.turn / kDegree) +
           ", about_mm: " + list(p.about / kMillimetre) + ", shift_mm: " + list(p.shift / kMillimetre) +
           "}\n";
  return out;
}

std::string moveYaml(const PlanMove& move, const Plan& plan, const Machine& machine) {
  std::string out;
  const std::vector<std::string> keys = jointKeys(machine);
  for (std::size_t j = 0; j < keys.size(); ++j)
    out += number(keys[j].c_str(), move.position[j] / readingUnit(machine.joints()[j]).factor);
  if (move.feature >= 0) out += ", feature: " + quoted(plan.artifact.features[move.feature].name);
  if (move.kind == MoveKind::kTouch) {
    const auto tip = [&](const std::vector<double>& q) {
      return machine.nominal(q.data(), kNotMeasured).position;
    };
    out += ", approach: " + list((tip(move.target) - tip(move.position)).normalized());
  }
  if (move.kind == MoveKind::kDeviation) out += ", reference: " + quoted(machine.joints()[move.joint].name);
  if (move.kind == MoveKind::kPosition) out += ", reference: position";
  if (move.kind == MoveKind::kLength) out += ", reference: length";
  if (!plan.placements.empty())
    out += ", placement: " + quoted(plan.placements[static_cast<std::size_t>(move.placement)].name);
  if (move.feature >= 0 && !plan.artifact.styli.empty())
    out += ", stylus: " + quoted(plan.artifact.styli[static_cast<std::size_t>(move.stylus)].name);
  if (!move.setup.empty()) out += ", setup: " + quoted(move.setup);
  if (move.speed > 0.0) out += number("speed_mm_s", move.speed / kMillimetre);
  if (move.wait > 0.0) out += number("wait_s", move.wait);
  return "{" + out.substr(2) + "}";
}

std::string artifactYaml(const Artifact& artifact, int indent) {
  const std::string in(static_cast<std::size_t>(indent), ' ');
  std::string out = in + "name: " + quoted(artifact.name) + "\n" + in +
                    "pose: " + (artifact.poseKnown ? "known" : "free") + "\n";
  if (!artifact.serial.empty()) out += in + "serial: " + quoted(artifact.serial) + "\n";
  out += in + "probe: {" +
         (artifact.styli.empty() ? format("tip_radius_mm: %.12g", artifact.tipRadius / kMillimetre)
                                 : "styli: " + stylusList(artifact));
  if (artifact.repeatability > 0.0) out += number("repeatability_um", artifact.repeatability / kMicrometre);
  out += "}\n";
  if (artifact.expansion != 0.0) out += in + format("expansion_per_K: %.12g\n", artifact.expansion);
  if (!artifact.temperatureSensor.empty())
    out += in + "temperature_sensor: " + quoted(artifact.temperatureSensor) + "\n";
  for (const FeatureKind kind : {FeatureKind::kBall, FeatureKind::kPoint}) {
    const bool ball = kind == FeatureKind::kBall;
    const std::string place = ball ? "centre" : "position";
    bool first = true;
    for (const Feature& f : artifact.features) {
      if (f.kind != kind) continue;
      if (first) out += in + (ball ? "balls" : "points") + ":\n";
      first = false;
      out += in + "  - {name: " + quoted(f.name);
      if (f.position.allFinite()) out += ", " + place + "_mm: " + list(f.position / kMillimetre);
      if (!f.known) out += ", " + place + ": free";
      if (ball) out += number("radius_mm", f.radius / kMillimetre);
      if (ball && f.radiusStd > 0.0) out += number("radius_std_um", f.radiusStd / kMicrometre);
      if (f.positionStd > 0.0) out += number((place + "_std_um").c_str(), f.positionStd / kMicrometre);
      out += "}\n";
    }
  }
  return out;
}

}  // namespace mm
