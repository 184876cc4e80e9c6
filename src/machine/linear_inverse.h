#pragma once
#include <Eigen/Core>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// Indices of the linear joints, from workpiece to probe_tip.
std::vector<int> linearJoints(const std::vector<Joint>& joints);

/// What the linear joints do to displace the tip, the rotary ones standing still.
struct LinearMotion {
  Eigen::VectorXd change;       // one a joint, added to its reading, m; 0 for the rotary ones
  bool everyDirection = false;  // the linear joints span space: any displacement can be had
  double missed = 0.0;          // m, what is left of the displacement; rounding where they span space
};

/// The shortest change of the linear joints that comes closest to a displacement of the tip.
/// @param linear their indices. @param byJoint a column a joint: displacement of the tip per unit of it
/// (m/m), in the frame of `displacement`; those of rotary joints are not read. @param displacement of the
/// tip, m.
LinearMotion linearMotion(const std::vector<int>& linear, const Eigen::Matrix3Xd& byJoint,
                          const Eigen::Vector3d& displacement);
/// The same along the nominal chain at the readings `q` (m, rad) and the beam's reading (m; NaN for a touch
/// probe); the displacement is in workpiece.
LinearMotion linearMotion(const Machine& machine, const double* q, double laserReading,
                          const Eigen::Vector3d& displacement);

/// Moves the linear joints of `q` (m, rad) so that the nominal probe is at `target` (workpiece, m); exact in
/// one step, as they move along straight lines. Limits of motion are not asked.
/// @return false, `q` untouched, when the linear joints do not reach every direction.
bool placeTip(const Machine& machine, const Eigen::Vector3d& target, double laserReading,
              std::vector<double>& q);

/// Whether every joint that has limits is within them, by at most `slack` (m or rad) outside.
bool withinLimits(const std::vector<Joint>& joints, const std::vector<double>& q, double slack = 0.0);

}  // namespace mm
