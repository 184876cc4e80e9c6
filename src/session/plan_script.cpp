#include "session/plan_script.h"

#include "session/plan_writer.h"

namespace mm {

int PlanScript::addPoint(const std::string& name, const Eigen::Vector3d& workpiece) {
  Feature point;
  point.kind = FeatureKind::kPoint;
  point.name = name;
  point.position = workpiece;
  plan_.artifact.features.push_back(point);
  return static_cast<int>(plan_.artifact.features.size()) - 1;
}

void PlanScript::write(PlanMove move) { text_ += indent() + "- " + moveYaml(move, plan_, machine_) + "\n"; }

void PlanScript::go(const Readings& to, double wait) {
  write({MoveKind::kGo, to, {}, -1, 0.0, wait, -1, ""});
}

void PlanScript::deviation(int joint, const Readings& at, double wait, const std::string& setup) {
  write({MoveKind::kDeviation, at, {}, -1, 0.0, wait, joint, setup});
}

void PlanScript::position(const Readings& at, double wait, const std::string& setup) {
  write({MoveKind::kPosition, at, {}, -1, 0.0, wait, -1, setup});
}

void PlanScript::length(int point, const Readings& at, double wait) {
  const Feature& from = plan_.artifact.features[static_cast<std::size_t>(point)];
  write({MoveKind::kLength, at, {}, point, 0.0, wait, -1, from.name});
}

void PlanScript::repeat(int times, const std::function<void()>& group) {
  text_ += indent() + "- repeats: " + std::to_string(times) + "\n" + indent() + "  moves:\n";
  ++depth_;
  group();
  --depth_;
}

std::string PlanScript::yaml() const {
  if (text_.empty()) return "";
  // With a name and a known pose, positions are told in the frame of the machine.
  Artifact artifact = plan_.artifact;
  artifact.name = artifact.features.empty() ? "indicators" : "beams";
  return "artifact:\n" + artifactYaml(artifact, 2) + "moves:\n" + text_;
}

}  // namespace mm
