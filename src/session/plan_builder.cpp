#include "session/plan_builder.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/rotation.h"
#include "base/units.h"
#include "machine/joint_units.h"
#include "machine/linear_inverse.h"
#include "session/plan_ways.h"

namespace mm {
namespace {

constexpr double kShortestApproach =
    0.3e-3;                                 // m: below it the play is not taken up and the ball may be missed
constexpr double kLimitSlack = 1e-9;        // m or rad: rounding of what is written in mm and deg
constexpr std::size_t kMostMoves = 300000;  // days of work for any machine
constexpr double kClose = 0.2e-3;           // m that the tip keeps from a ball when it passes

}  // namespace

PlanBuilder::PlanBuilder(Plan& plan, const Machine& machine) : plan_(plan), machine_(machine) {
  for (const Joint& joint : machine_.joints())
    current_.push_back(joint.upper > joint.lower ? std::clamp(0.0, joint.lower, joint.upper) : 0.0);
}

void PlanBuilder::fail(const std::string& message) const {
  throw InputError(plan_.source + ":" + std::to_string(line_) + ": " + what_ + ": " + message);
}

Eigen::Vector3d PlanBuilder::tip(const std::vector<double>& readings) const {
  offset();  // refuses a stylus without one
  return plan_.tipOf(machine_, readings, stylus_);
}

Eigen::Vector3d PlanBuilder::offset() const {
  if (plan_.artifact.styli.empty()) return Eigen::Vector3d::Zero();
  const Stylus& stylus = plan_.artifact.styli[static_cast<std::size_t>(stylus_)];
  if (!stylus.offset.allFinite())
    fail("stylus '" + stylus.name +
         "' has no offset, so it cannot be moved to a ball: give 'offset_mm' as well as it is known; with "
         "'offset: free' it is estimated");
  return stylus.offset;
}

Eigen::Vector3d PlanBuilder::beam(const std::vector<double>& readings) const {
  return machine_.nominal(readings.data(), kNotMeasured).orientation.col(2);
}

std::vector<double> PlanBuilder::reach(const Eigen::Vector3d& target, std::vector<double> readings) const {
  const Eigen::Matrix3d orientation = machine_.nominal(readings.data(), kNotMeasured).orientation;
  if (!placeTip(machine_, target - orientation * offset(), kNotMeasured, readings))
    fail("machine '" + machine_.name() +
         "' lacks three linear joints that reach every direction; give the readings under 'moves'");
  return readings;
}

bool PlanBuilder::withinLimits(const std::vector<double>& readings) const {
  return mm::withinLimits(machine_.joints(), readings, kLimitSlack);
}

void PlanBuilder::checkLimits(const std::vector<double>& readings) const {
  if (withinLimits(readings)) return;
  for (int j = 0; j < machine_.jointCount(); ++j) {
    const Joint& joint = machine_.joints()[j];
    std::vector<double> one = current_;
    one[j] = readings[j];
    if (withinLimits(one)) continue;
    const auto [unit, symbol] = readingUnit(joint);
    fail(format("joint '%s' would move to %g, but its limits are %g to %g %s", joint.name.c_str(),
                readings[j] / unit, joint.lower / unit, joint.upper / unit, symbol));
  }
}

double PlanBuilder::contactDistance(int feature) const {
  const Feature& f = plan_.artifact.features[feature];
  if (f.kind != FeatureKind::kBall) fail("'" + f.name + "' is a point; only balls can be touched");
  return f.radius + plan_.artifact.tipRadiusOf(stylus_);
}

Eigen::Vector3d PlanBuilder::centre(int feature) const {
  const Feature& f = plan_.artifact.features[feature];
  if (!f.position.allFinite())
    fail("'" + f.name + "' has no position in the artifact; give an approximate position as start value");
  return plan_.placeOf(feature, placement_);
}

void PlanBuilder::checkCount(std::size_t more) const {
  if (plan_.moves.size() + more > kMostMoves)
    fail("makes more than " + std::to_string(kMostMoves) + " moves; ask for fewer points, repeats or runs");
}

void PlanBuilder::append(PlanMove move) {
  checkLimits(move.position);
  if (move.kind == MoveKind::kTouch) checkLimits(move.target);
  checkCount(1);
  move.line = line_;
  move.placement = placement_;
  move.stylus = stylus_;
  current_ = move.position;
  plan_.moves.push_back(std::move(move));
}

void PlanBuilder::go(const std::vector<double>& position, double speed, double wait) {
  append({MoveKind::kGo, position, {}, -1, speed, wait, -1, ""});
}

void PlanBuilder::comeFrom(const std::vector<int>& sides, std::vector<double> position) {
  bool any = false;
  for (std::size_t j = 0; j < sides.size(); ++j) {
    if (sides[j] == 0) continue;
    const Joint& joint = machine_.joints()[j];
    position[j] += sides[j] * (joint.kind == JointKind::kLinear ? overrun : overrunRotary);
    if (joint.upper > joint.lower) position[j] = std::clamp(position[j], joint.lower, joint.upper);
    any = true;
  }
  if (any) goAround(position);
}

bool PlanBuilder::blocked(const std::vector<double>& from, const std::vector<double>& to) const {
  const std::vector<Eigen::Vector3d> way = {tip(from), tip(to)};
  for (std::size_t i = 0; i < plan_.artifact.features.size(); ++i) {
    const Feature& f = plan_.artifact.features[i];
    if (f.kind != FeatureKind::kBall || !f.position.allFinite()) continue;
    if (distanceToWay(plan_.placeOf(static_cast<int>(i), placement_), way) <
        f.radius + plan_.artifact.tipRadiusOf(stylus_) + kClose)
      return true;
  }
  return false;
}

void PlanBuilder::goAround(const std::vector<double>& position) {
  if (!clearance.empty() && blocked(current_, position)) {
    std::vector<double> above = current_, beyond = position;
    for (const auto& [joint, reading] : clearance) above[joint] = beyond[joint] = reading;
    go(above);
    go(beyond);
  }
  go(position);
}

void PlanBuilder::touchAt(int feature, const Eigen::Vector3d& contact, const Eigen::Vector3d& approach,
                          double speed, std::vector<double> rotary, const std::vector<int>& sides,
                          double wait) {
  double distance = approachDistance, beyond = overtravel;
  PlanMove move{MoveKind::kTouch,
                reach(contact - distance * approach, rotary),
                reach(contact + beyond * approach, rotary),
                feature,
                speed,
                wait,
                -1,
                ""};
  while (!withinLimits(move.position) && distance > kShortestApproach)
    move.position = reach(contact - (distance *= 0.8) * approach, rotary);
  while (!withinLimits(move.target) && beyond > kShortestApproach)
    move.target = reach(contact + (beyond *= 0.8) * approach, rotary);
  if (!sides.empty()) comeFrom(sides, move.position);
  if (!clearance.empty() && blocked(current_, move.position)) goAround(move.position);
  append(std::move(move));
}

void PlanBuilder::touchFrom(int feature, const std::vector<double>& start, Eigen::Vector3d approach,
                            double speed, const std::vector<int>& sides, double wait) {
  const double distance = contactDistance(feature);
  const Eigen::Vector3d from = tip(start), to = centre(feature) - from;
  if (approach.isZero(0.0)) approach = to;
  if (approach.norm() < kNoDirection) fail("the approach has no direction; give 'approach' or another start");
  approach.normalize();
  const double along = to.dot(approach), aside = (to - along * approach).norm();
  if (aside >= distance)
    fail("the approach passes '" + plan_.artifact.features[feature].name +
         format("' at %g mm from its centre, but contact is only possible within %g mm", aside / kMillimetre,
                distance / kMillimetre));
  const double way = along - std::sqrt(distance * distance - aside * aside);
  const double before = approachDistance;
  // A start as near as the contact itself says where to touch, not where to begin.
  if (way >= kShortestApproach) approachDistance = way;
  touchAt(feature, from + way * approach, approach, speed, start, sides, wait);
  approachDistance = before;
}

void PlanBuilder::readLaser(int feature, const std::vector<double>& position, double wait) {
  append({MoveKind::kLaser, position, {}, feature, 0.0, wait, -1, ""});
}

void PlanBuilder::reference(MoveKind kind, int joint, const std::vector<double>& position, double speed,
                            double wait, const std::string& setup) {
  append({kind, position, {}, -1, speed, wait, joint, setup});
}

void PlanBuilder::length(int feature, const std::vector<double>& position, double speed, double wait,
                         const std::string& setup) {
  const Feature& from = plan_.artifact.features[feature];
  if (from.kind != FeatureKind::kPoint)
    fail("'" + from.name + "' is a ball; a length begins at a point of the artifact");
  append({MoveKind::kLength, position, {}, feature, speed, wait, -1, setup});
}

void PlanBuilder::again(std::size_t first, int times) {
  const std::vector<PlanMove> group(plan_.moves.begin() + static_cast<std::ptrdiff_t>(first),
                                    plan_.moves.end());
  checkCount(group.size() * static_cast<std::size_t>(times));
  for (int i = 0; i < times; ++i) plan_.moves.insert(plan_.moves.end(), group.begin(), group.end());
}

}  // namespace mm
