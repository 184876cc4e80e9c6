#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/dense.h"
#include "base/format.h"
#include "compensation/compensator.h"
#include "machine/joint_units.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr int kMostIterations = 50;
constexpr double kReached = 1e-11;  // m: far below any scale, above the rounding of a metre
constexpr double kMoved = 1e-9;     // m or rad: a smaller move has no direction
constexpr int kTurns = 4;           // as often may the direction of a joint change while it is looked for

/// Changes of the readings (m, rad) for a displacement of the tip (m): of the linear joints, or of all where
/// these cannot reach every direction.
Eigen::VectorXd changesFor(const Machine& machine, const std::vector<double>& position, double beam,
                           const Eigen::Vector3d& displacement) {
  const Eigen::Matrix3Xd byJoint = machine.jacobian(position.data(), beam).topRows<3>();
  const LinearMotion motion = linearMotion(linearJoints(machine.joints()), byJoint, displacement);
  if (motion.everyDirection) return motion.change;
  return shortestLeastSquares(byJoint, displacement);
}

std::string beyondLimits(const Machine& machine, const std::vector<double>& position) {
  for (int j = 0; j < machine.jointCount(); ++j) {
    const Joint& joint = machine.joints()[j];
    if (!(joint.lower < joint.upper) || (position[j] >= joint.lower && position[j] <= joint.upper)) continue;
    const JointUnit unit = readingUnit(joint);
    return "joint " + joint.name +
           format(" would have to go to %.6g %s, its limits are %.6g to %.6g", position[j] / unit.factor,
                  unit.symbol, joint.lower / unit.factor, joint.upper / unit.factor);
  }
  return {};
}

}  // namespace

TargetReadings Compensator::correctTarget(const Eigen::Vector3d& truePoint, MovingState start,
                                          const std::vector<double>& arrival) const {
  TargetReadings target;
  target.position = start.position;
  if (!truePoint.allFinite()) {
    target.reason = "the target is not a finite point";
    return target;
  }
  const Machine& machine = model_.machine();
  const std::size_t joints = start.position.size();
  const double beam = model_.domain().laser ? start.laserReading : std::numeric_limits<double>::quiet_NaN();
  const MovingState now = start;
  std::vector<int> turns(joints, 0);
  std::string upwards;
  Workspace work;
  constexpr double kFar = std::numeric_limits<double>::infinity();
  start.sinceReversal.assign(joints, kFar);
  start.back.clear();
  for (std::size_t j = 0; j < std::min(joints, arrival.size()); ++j)
    if (arrival[j] != 0.0) start.travel[j] = arrival[j];
  // Of a joint that the move brings from another place, the direction of its last motion says nothing.
  const auto travelOfMove = [&](std::size_t j) {
    const double moved = start.position[j] - now.position[j];
    const bool told = j < arrival.size() && arrival[j] != 0.0;
    if (!told && std::abs(moved) >= kMoved && turns[j] < kTurns) {
      const double direction = moved > 0.0 ? 1.0 : -1.0;
      if (start.travel[j] == -direction && limits_->usesTravel(j)) ++turns[j];
      start.travel[j] = direction;
      if (turns[j] == kTurns) {  // it is nearer than the play: from either side the readings lie behind
        start.travel[j] = 1.0;
        upwards += (upwards.empty() ? "" : ", ") + machine.joints()[j].name;
      }
    }
    if (turns[j] == kTurns || told) return;  // whoever is told approaches it from far enough
    const bool goesOn = now.travel[j] != 0.0 && start.travel[j] == now.travel[j];
    start.sinceReversal[j] = goesOn ? now.sinceReversalOf(static_cast<int>(j)) + std::abs(moved)
                             : now.travel[j] == 0.0 ? kFar
                                                    : std::abs(moved);
  };
  model_.place(start);
  for (target.iterations = 0;; ++target.iterations) {
    target.correction = apply(start, &start, work);
    const Eigen::Vector3d miss = truePoint - target.correction.corrected.position;
    target.position = start.position;
    target.sigma = target.correction.sigma;
    if (target.iterations > 0 && miss.norm() <= kReached * (1.0 + truePoint.norm())) break;
    if (target.iterations == kMostIterations || (target.iterations > 0 && !miss.allFinite())) {
      target.reason = target.correction.reason.empty() ? "no readings reach the target within 50 steps"
                                                       : target.correction.reason;
      return target;
    }
    // Before the first step an unknown travel may leave the correction unknown: the nominal chain gives the
    // step.
    const Eigen::Vector3d step =
        miss.allFinite() ? miss : Eigen::Vector3d(truePoint - target.correction.nominal.position);
    const Eigen::VectorXd changes = changesFor(machine, start.position, beam, step);
    for (int j = 0; j < machine.jointCount(); ++j) {
      start.position[j] += changes[j];
      travelOfMove(static_cast<std::size_t>(j));
    }
    model_.place(start);
  }
  target.reason = target.correction.valid ? beyondLimits(machine, target.position) : target.correction.reason;
  target.reached = target.reason.empty();
  if (!upwards.empty())
    target.correction.note +=
        (target.correction.note.empty() ? "" : "; ") +
        ("the target is nearer than the backlash of " + upwards + ": approach it upwards in " + upwards +
         ", from further below than the backlash");
  return target;
}

}  // namespace mm
