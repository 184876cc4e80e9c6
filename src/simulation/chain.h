#pragma once
#include <vector>

#include "machine/machine.h"
#include "simulation/source.h"

namespace mm {

/// The simulated instrument's own kinematics: finite motions of rigid bodies about each joint's place at zero
/// (product of exponentials), with the errors of a Distortion; exact in every angle. SI units, frame
/// workpiece.
class Chain {
 public:
  /// Reads the URDF of the machine by itself. @throw InputError
  explicit Chain(const Machine& machine);

  /// Tip and orientation at these positions of the slides. The probe's own errors are in.
  ProbePose pose(const std::vector<double>& slides, const Distortion& distortion) const;
  ProbePose nominal(const std::vector<double>& readings) const;

  int jointCount() const { return static_cast<int>(joints_.size()); }  ///< moving joints
  JointKind kind(int joint) const { return joints_[joint].kind; }      ///< linear or rotary
  /// Direction of a joint in workpiece with all joints at zero.
  const Eigen::Vector3d& axis(int joint) const { return joints_[joint].axis; }

  /// Readings of the linear joints that put the nominal tip at `tip`, the rotary ones staying as in
  /// `readings`.
  /// @throw InputError when the machine has not three independent linear joints.
  std::vector<double> reach(const Eigen::Vector3d& tip, std::vector<double> readings) const;

 private:
  struct Place {
    JointKind kind;
    Eigen::Vector3d origin, axis;
  };
  std::vector<Place> joints_;
  int tableJoints_ = 0;  // the first ones: their fixed side is that of the tip
  ProbePose zero_;
};

}  // namespace mm
