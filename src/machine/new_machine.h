#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// A machine as its owner tells it: axes in the order from the workpiece to the probe.
struct NewMachine {
  struct Axis {
    std::string name;
    JointKind kind = JointKind::kLinear;
    double lower = 0.0, upper = 0.0;  // m or rad
    Eigen::Vector3d direction =
        Eigen::Vector3d::UnitX();  // of a positive reading: the probe moves or turns so
  };
  std::string name;
  std::vector<Axis> axes;
  Eigen::Vector3d tip = Eigen::Vector3d::Zero();  // of the probe from the last axis, m
  double speed = 0.02;                            // m/s; rotary axes: rad/s, ten times that number
};

/// Its URDF, which Machine reads. @throw InputError: no axis, a name that is no name or comes twice, a travel
/// that is empty, a direction that is zero.
std::string newMachineUrdf(const NewMachine& machine);

}  // namespace mm
