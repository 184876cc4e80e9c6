#pragma once
#include <map>
#include <string>
#include <vector>

#include "machine/machine.h"

namespace mm {

/// A joint of the machine as its controller calls it.
struct ExportAxis {
  int joint = 0;       // index in the machine
  std::string name;    // of the joint
  std::string letter;  // of the controller's axis, in small letters: x y z a b c u v w
  JointKind kind = JointKind::kLinear;
  double lower = 0.0, upper = 0.0;  // range that the session observed, m or rad
};

/// Which letter a controller has for each joint: a joint called by a letter has that one; another linear
/// joint the letter of the workpiece's axis along which it moves most, u, v, w where that is taken; another
/// rotary one a, b, c by the axis about which it turns.
/// @param told joint -> letter, by the user; wins. @param lower, upper observed range, a joint.
/// @throw InputError: no linear joint, a joint that the machine does not have, a letter that is none or comes
/// twice.
std::vector<ExportAxis> exportAxes(const Machine& machine, const std::map<std::string, std::string>& told,
                                   const std::vector<double>& lower, const std::vector<double>& upper);

}  // namespace mm
