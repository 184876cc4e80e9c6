#pragma once
#include <string>

#include "machine/machine.h"

namespace mm {

/// Where an effect acts: on the reading of a joint, along an axis of the workpiece, or along the approach.
struct Direction {
  enum class Kind { kJoint, kWorkpiece, kApproach };
  Kind kind = Kind::kJoint;
  int index = 0;  // joint, or 0-2 for x, y, z of the workpiece
  std::string name;
  JointKind quantity = JointKind::kLinear;  // a displacement in m, or an angle in rad

  /// Slot of the ErrorLayout; not for the approach, which has three.
  int slot(const ErrorLayout& layout) const {
    return kind == Kind::kJoint ? layout.axis(index) : layout.volume(index);
  }
};

}  // namespace mm
