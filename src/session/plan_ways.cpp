#include "session/plan_ways.h"

#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kShallow = 1e-6;         // m: rounding of what is written in mm
constexpr double kTurn = 2.0 * kDegree;   // of a rotary joint, between two places of a curved way
constexpr std::size_t kMostPlaces = 200;  // of one way

/// The nominal tip (workpiece, m) along a straight way of the joints.
std::vector<Eigen::Vector3d> wayOfTip(const Plan& plan, const Machine& machine,
                                      const std::vector<double>& from, const PlanMove& move) {
  const std::vector<double>& to = move.position;
  double turn = 0.0;
  for (int j = 0; j < machine.jointCount(); ++j)
    if (machine.joints()[j].kind == JointKind::kRotary) turn = std::max(turn, std::abs(to[j] - from[j]));
  const std::size_t pieces = std::min(kMostPlaces, static_cast<std::size_t>(std::ceil(turn / kTurn)) + 1);
  std::vector<Eigen::Vector3d> way;
  std::vector<double> at = from;
  for (std::size_t i = 0; i <= pieces; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(pieces);
    for (std::size_t j = 0; j < at.size(); ++j) at[j] = from[j] + part * (to[j] - from[j]);
    way.push_back(plan.tipOf(machine, at, move.stylus));
  }
  return way;
}

bool isBall(const Feature& feature) {
  return feature.kind == FeatureKind::kBall && feature.position.allFinite();
}

/// Whether both balls can be there at the same time.
bool together(const Feature& a, const Feature& b) {
  return (a.position - b.position).norm() >= a.radius + b.radius;
}

}  // namespace

double distanceToWay(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& way) {
  double nearest = INFINITY;
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Eigen::Vector3d piece = way[i] - way[i - 1];
    const double length = piece.squaredNorm();
    const double along = length > 0.0 ? std::clamp((point - way[i - 1]).dot(piece) / length, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (way[i - 1] + along * piece - point).norm());
  }
  return nearest;
}

std::vector<BlockedWay> blockedWays(const Plan& plan, const Machine& machine) {
  std::vector<BlockedWay> blocked;
  if (plan.laser) return blocked;
  const std::vector<Feature>& features = plan.artifact.features;
  int touched = -1;
  for (std::size_t m = 0; m < plan.moves.size(); ++m) {
    const PlanMove& move = plan.moves[m];
    if (move.feature >= 0) touched = move.feature;
    if (m == 0 || plan.standText(plan.moves[m - 1]) != plan.standText(move)) continue;
    const std::vector<Eigen::Vector3d> way = wayOfTip(plan, machine, plan.moves[m - 1].position, move);
    BlockedWay worst{m, -1, kShallow};
    for (int f = 0; f < static_cast<int>(features.size()); ++f) {
      if (!isBall(features[f])) continue;
      if (touched >= 0 && f != touched && isBall(features[touched]) &&
          !together(features[f], features[touched]))
        continue;
      const double depth = features[f].radius + plan.artifact.tipRadiusOf(move.stylus) -
                           distanceToWay(plan.placeOf(f, move.placement), way);
      if (depth > worst.depth) worst = {m, f, depth};
    }
    if (worst.ball >= 0) blocked.push_back(worst);
  }
  return blocked;
}

std::string blockedWaysText(const Plan& plan, const std::vector<BlockedWay>& ways) {
  if (ways.empty()) return {};
  const BlockedWay& first = ways.front();
  const PlanMove& move = plan.moves[first.move];
  const std::vector<Feature>& features = plan.artifact.features;
  std::string text =
      plan.source + ":" + std::to_string(move.line) + ": the way to move " + std::to_string(first.move) +
      (move.kind == MoveKind::kTouch ? ", a touch of '" + features[move.feature].name + "'," : "") +
      " leads through ball '" + features[first.ball].name + "', " +
      format("%.3g", first.depth / kMillimetre) + " mm deep";
  if (ways.size() > 1) text += ", and so do " + std::to_string(ways.size() - 1) + " more ways through a ball";
  return text +
         "; on a machine the probe would collide there: give 'clearance' a joint and a reading at which "
         "everything can be passed, or put moves between";
}

}  // namespace mm
