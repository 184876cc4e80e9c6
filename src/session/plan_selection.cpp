#include "session/plan_selection.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "base/names_of.h"
#include "base/numbered_names.h"
#include "session/plan_writer.h"

namespace mm {
namespace {

constexpr double kSlowest = 1e-9;  // m/s: a move that says none takes for ever

/// Where the tip trips on its way from `from` to `to`, as a share of the way; 1 where it does not.
double shareOfWay(const Plan& plan, const PlanMove& move, const Eigen::Vector3d& from,
                  const Eigen::Vector3d& to) {
  const Feature& ball = plan.artifact.features[static_cast<std::size_t>(move.feature)];
  const Eigen::Vector3d way = to - from, aside = from - plan.placeOf(move.feature, move.placement);
  const double reach = ball.radius + plan.artifact.tipRadiusOf(move.stylus);
  const double a = way.squaredNorm(), b = aside.dot(way), c = aside.squaredNorm() - reach * reach;
  const double square = b * b - a * c;
  return a > 0.0 && square > 0.0 ? std::clamp((-b - std::sqrt(square)) / a, 0.0, 1.0) : 1.0;
}

void touched(const Plan& plan, const Machine& machine, const PlanMove& move, Observation& o) {
  const Eigen::Vector3d from = plan.tipOf(machine, move.position, move.stylus),
                        to = plan.tipOf(machine, move.target, move.stylus);
  const double share = shareOfWay(plan, move, from, to);
  const double seconds = (to - from).norm() / std::max(kSlowest, move.speed);
  o.approach = (to - from).normalized();
  for (std::size_t j = 0; j < o.position.size(); ++j) {
    const double way = move.target[j] - move.position[j];
    o.position[j] += share * way;
    o.velocity[j] = way / seconds;
    if (way != 0.0) o.travel[j] = way > 0.0 ? 1.0 : -1.0;
  }
}

}  // namespace

std::string planSelection(const Plan& plan, const Machine& machine, const std::vector<std::size_t>& moves,
                          const std::string& name) {
  std::string text = "name: " + name + "\n";
  if (!plan.artifact.features.empty()) text += "artifact:\n" + artifactYaml(plan.artifact, 2);
  const YAML::Node root = YAML::Load(plan.text);
  for (const char* key : {"probe", "speeds", "approach", "clearance", "instrument"})
    if (root[key]) {
      YAML::Node one;
      one[key] = root[key];
      text += YAML::Dump(one) + "\n";
    }
  text += placementsYaml(plan) + "moves:\n";
  for (const std::size_t i : moves) {
    const PlanMove& move = plan.moves[i];
    // a position that an instrument reads is reached from the side from which the plan reaches it
    if (byInstrument(move.kind) && i > 0 && plan.moves[i - 1].kind == MoveKind::kGo)
      text += "  - " + moveYaml(plan.moves[i - 1], plan, machine) + "\n";
    text += "  - " + moveYaml(move, plan, machine) + "\n";
  }
  return text;
}

Session plannedSession(const Plan& plan, const Machine& machine, std::vector<std::size_t>* moves) {
  Session session(machine);
  session.artifact = plan.artifact;
  session.source = plan.source;
  session.placements = allNames(plan.placements);
  NumberedNames setups;
  const std::size_t joints = machine.joints().size();
  std::vector<double> before, travel(joints, 0.0);
  double time = 0.0;
  for (std::size_t i = 0; i < plan.moves.size(); ++i) {
    const PlanMove& move = plan.moves[i];
    for (std::size_t j = 0; j < joints && !before.empty(); ++j)
      if (move.position[j] != before[j]) travel[j] = move.position[j] > before[j] ? 1.0 : -1.0;
    before = move.position;
    time += 1.0;
    if (move.kind == MoveKind::kGo) continue;
    Observation o;
    o.time = time;
    o.row = static_cast<std::int64_t>(session.observations.size()) + 1;
    o.position = move.position;
    o.velocity.assign(joints, 0.0);
    o.travel = travel;
    o.feature = move.feature;
    o.placement = move.placement;
    o.stylus = move.stylus;
    if (move.kind == MoveKind::kTouch) touched(plan, machine, move, o);
    if (move.kind == MoveKind::kLaser) {
      o.laserReading = 0.0;
      o.approach = machine.nominal(o.position.data(), 0.0).orientation.col(2);
    }
    if (move.kind == MoveKind::kPosition) {
      o.kind = ObservationKind::kPosition;
      o.reference = machine.nominal(o.position.data(), kNotMeasured).position;
    }
    if (move.kind == MoveKind::kDeviation) {
      o.kind = ObservationKind::kDeviation;
      o.deviation.assign(joints, kNotMeasured);
      o.deviation[static_cast<std::size_t>(move.joint)] = 0.0;
    }
    if (move.kind == MoveKind::kLength) {
      o.kind = ObservationKind::kLength;
      o.length =
          (plan.tipOf(machine, move.position, move.stylus) - plan.placeOf(move.feature, move.placement))
              .norm();
    }
    if (byInstrument(move.kind) && !move.setup.empty()) o.setup = setups[move.setup];
    session.observations.push_back(std::move(o));
    if (moves != nullptr) moves->push_back(i);
  }
  session.setups = setups.all();
  return session;
}

}  // namespace mm
