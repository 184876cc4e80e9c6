#pragma once
#include <vector>

namespace mm {

/// Readings on the way between two measurements, as /joint_states has them. SI units, one value a joint.
struct MotionSample {
  double time = 0.0;  // s from the session's start
  std::vector<double> position, velocity;
};

}  // namespace mm
