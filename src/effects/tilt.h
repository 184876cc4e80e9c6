#pragma once
#include <cmath>
#include <string>

#include "effects/effect.h"
#include "machine/machine.h"

namespace mm {

/// "x", "y" or "z".
inline std::string axisName(int k) { return std::string(1, static_cast<char>('x' + k)); }

/// Whether a linear joint runs across axis k of the workpiece: it takes up the displacements of a turn about
/// it.
inline bool isAcross(const Joint& joint, int k) {
  constexpr double kAcross = 0.7;  // cosine between the two: of a larger one it runs along
  return joint.kind == JointKind::kLinear && !(std::abs(joint.axis[k]) > kAcross);
}

/// Adds a small rotation `angle = value * basis` about axis k of the workpiece, through its origin: the
/// displacement angle * (k x lever) and the turn of the probe.
inline void addTilt(const ErrorLayout& layout, int k, const State& state, int parameter, double value,
                    double basis, ErrorSink& sink) {
  const int next = (k + 1) % 3, last = (k + 2) % 3;
  sink.add(layout.volume(next), parameter, value, -basis * state.tip[last]);
  sink.add(layout.volume(last), parameter, value, basis * state.tip[next]);
  sink.add(layout.orientation(k), parameter, value, basis);
}

}  // namespace mm
