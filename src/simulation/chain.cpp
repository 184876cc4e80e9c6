#include "simulation/chain.h"

#include <limits>

#include "base/error.h"
#include "base/rotation.h"
#include "machine/linear_inverse.h"

namespace mm {

Chain::Chain(const Machine& machine) {
  const std::vector<double> q(machine.joints().size(), 0.0);
  const std::vector<double> none(static_cast<std::size_t>(machine.layout().size()), 0.0);
  Eigen::Matrix<double, 6, Eigen::Dynamic> gradient;
  zero_ = machine.measure(q.data(), std::numeric_limits<double>::quiet_NaN(), none.data(), &gradient);
  const ErrorLayout at = machine.layout();
  tableJoints_ = machine.tableJoints();
  for (int j = 0; j < machine.jointCount(); ++j) {
    // The joint's place follows from how the tip moves under a small rotation at its fixed side: dp = w x
    // (tip - origin).
    const Eigen::Matrix3d frame = gradient.block<3, 3>(0, at.jointTranslation(j, 0));
    const Eigen::Matrix3d arm = gradient.block<3, 3>(0, at.jointRotation(j, 0)) * frame.transpose();
    const Eigen::Vector3d lever(arm(1, 2), arm(2, 0), arm(0, 1));  // arm = -[lever]x
    const JointKind kind = machine.joints()[j].kind;
    const Eigen::Vector3d axis = gradient.block<3, 1>(kind == JointKind::kLinear ? 0 : 3, at.axis(j));
    joints_.push_back({kind, zero_.position - lever, axis.normalized()});
  }
}

ProbePose Chain::pose(const std::vector<double>& slides, const Distortion& d) const {
  // x -> linear * x + offset gathers the motions from the workpiece outwards
  Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  const auto then = [&](const Eigen::Matrix3d& r, const Eigen::Vector3d& about,
                        const Eigen::Vector3d& shift) {
    moved += turned * (about - r * about + shift);
    turned = turned * r;
  };
  for (int j = 0; j < jointCount(); ++j) {
    const Place& place = joints_[j];
    const double travel = slides[j] + d.travel[j];
    const auto displace = [&](double sign) {
      if (!d.tilt[j].isZero(0.0) || !d.shift[j].isZero(0.0))
        then(rotationBy(sign * d.tilt[j]), place.origin, sign * d.shift[j]);
    };
    if (j >= tableJoints_) displace(1.0);
    if (place.kind == JointKind::kLinear)
      moved += turned * place.axis * travel;
    else
      then(rotationBy(place.axis * travel), place.origin, Eigen::Vector3d::Zero());
    if (j < tableJoints_) displace(-1.0);
  }
  ProbePose pose;
  pose.orientation = turned * zero_.orientation;
  pose.position = turned * zero_.position + moved + pose.orientation * d.probeShift;
  if (!d.tipTilt.isZero(0.0)) {
    const Eigen::Matrix3d tip = rotationBy(d.tipTilt);
    pose.position = tip * pose.position;
    pose.orientation = tip * pose.orientation;
  }
  pose.position += d.tipShift;
  return pose;
}

ProbePose Chain::nominal(const std::vector<double>& readings) const {
  return pose(readings, Distortion(jointCount()));
}

std::vector<double> Chain::reach(const Eigen::Vector3d& tip, std::vector<double> readings) const {
  std::vector<int> linear;
  for (int j = 0; j < jointCount(); ++j)
    if (joints_[j].kind == JointKind::kLinear) linear.push_back(j);
  for (const int j : linear) readings[j] = 0.0;
  const Eigen::Vector3d start = nominal(readings).position;
  Eigen::Matrix3Xd byJoint = Eigen::Matrix3Xd::Zero(3, jointCount());
  for (const int j : linear) {
    std::vector<double> unit = readings;
    unit[j] = 1.0;
    byJoint.col(j) = nominal(unit).position - start;
  }
  const LinearMotion motion = linearMotion(linear, byJoint, tip - start);
  if (!motion.everyDirection)
    throw InputError(
        "the machine has not three linear joints that reach every direction; give the plan's moves joint by "
        "joint under `moves`");
  for (const int j : linear) readings[j] = motion.change[j];
  return readings;
}

}  // namespace mm
