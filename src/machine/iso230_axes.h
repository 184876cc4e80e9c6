#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// Axes of the fixed side of each joint in `workpiece`, at zero readings: those of its errors.
std::vector<Eigen::Matrix3d> fixedSides(const Machine& machine);

/// 0, 1 or 2 where a direction of `workpiece` is that of x, y or z, whatever its sign, within 10 degrees;
/// else -1: ISO 230-1 has no letter for it.
int alongWorkpieceAxis(const Eigen::Vector3d& direction);

/// A moving axis as ISO 841 and ISO 230-1 name it: by the axis of `workpiece` along or about which it moves,
/// whatever its joint is called. At zero readings.
struct Iso230Axis {
  /// X, Y, Z or A, B, C. Further axes of the same direction are U, V, W and P, Q, R (ISO 841), or C2, C3; the
  /// one whose joint is called by the first letter has it, else the nearest to the workpiece. Empty: it moves
  /// along no axis of `workpiece`.
  std::string name;
  JointKind kind = JointKind::kLinear;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();      // unit vector in `workpiece`
  Eigen::Matrix3d fixedSide = Eigen::Matrix3d::Identity();  // axes of the joint's fixed side in `workpiece`
};

/// One a joint, from workpiece to probe_tip.
std::vector<Iso230Axis> iso230Axes(const Machine& machine);

/// The kinematic chain from the workpiece w over the bed b to the probe t, in the order of ISO 10791-6,
/// without its primes: "w-Y-X-b-Z-C-A-t". The bed is the link of the URDF where the branches of workpiece and
/// probe_tip meet. An axis without a letter stands by its joint's name in quotes.
std::string kinematicChain(const Machine& machine);

}  // namespace mm
