#pragma once
#include "base/units.h"
#include "machine/machine.h"

namespace mm {

/// A unit in which people read what belongs to a joint: value in SI = value in it * factor.
struct JointUnit {
  double factor = 1.0;
  const char* symbol = "";
};

/// Of readings: mm of a linear joint, deg of a rotary one.
inline JointUnit readingUnit(const Joint& joint) {
  return joint.kind == JointKind::kLinear ? JointUnit{kMillimetre, "mm"} : JointUnit{kDegree, "deg"};
}

/// Of errors and deviations: um, arcsec.
inline JointUnit errorUnit(const Joint& joint) {
  return joint.kind == JointKind::kLinear ? JointUnit{kMicrometre, "um"} : JointUnit{kArcsecond, "arcsec"};
}

}  // namespace mm
