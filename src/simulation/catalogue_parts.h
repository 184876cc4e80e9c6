#pragma once
#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "simulation/catalogue.h"

namespace mm {

/// Rotary axes: zero, place and direction of the axis, graduation, wobble.
std::vector<SourceKind> rotaryKinds();

/// What the makers of sources share.
namespace source_kinds {

/// A source of type T among those of the machine.
template <typename T, typename... Arguments>
void add(Workshop& w, Arguments&&... arguments) {
  w.physics.sources.push_back(std::make_shared<T>(std::forward<Arguments>(arguments)...));
}

/// The joint that a key names; -1: none of that name.
inline int joint(const HiddenSource& s, const Workshop& w, const char* key) {
  return w.machine.findJoint(s.key(key));
}

/// Of `x`, `y` or `z`.
inline Eigen::Vector3d unitVector(const std::string& name) { return Eigen::Vector3d::Unit(name[0] - 'x'); }

}  // namespace source_kinds
}  // namespace mm
