#pragma once
#include <Eigen/Geometry>
#include <array>
#include <set>
#include <string>

#include "effects/effect.h"
#include "effects/spec_reader.h"

namespace mm {

/// True when the axis of rotation is axis k of the joint's fixed side: displaced along it or turned about it,
/// it stays.
inline bool alongAxis(const Joint& joint, int k) { return std::abs(joint.axis[k]) > 1.0 - 1e-9; }

/// Two unit vectors across the axis of rotation, in the axes of the joint's fixed side: two of these axes
/// themselves where the rotation is about the third (then named x, y or z), else any pair (named u, w).
struct RadialDirections {
  RadialDirections(const SpecReader& read, int index) {
    const Joint& joint = read.domain().joints[index];
    if (joint.axis.squaredNorm() < 0.5)
      read.fail("the axis of joint '" + joint.name + "' is not known to the domain");
    for (int k = 0; k < 3; ++k) {
      if (!alongAxis(joint, k)) continue;
      for (int d = 0; d < 2; ++d) {
        const int axis = (k + 1 + d) % 3;
        directions[d] = Eigen::Vector3d::Unit(axis);
        names[d] = std::string(1, static_cast<char>('x' + axis));
      }
      return;
    }
    directions[0] = joint.axis.unitOrthogonal();
    directions[1] = joint.axis.cross(directions[0]);
  }

  std::array<Eigen::Vector3d, 2> directions;
  std::array<std::string, 2> names{"u", "w"};
};

constexpr int kHighestHarmonic = 16;  // of a turn

/// The other harmonics of a bearing: no race is exactly round or exactly an ellipse, and no wave is a pure
/// sine.
inline std::vector<ShapeFreedom> otherHarmonics(const EffectSpec& spec, int harmonic, int highest) {
  std::set<int> others{1, 2, 3, 2 * harmonic};
  others.erase(harmonic);
  std::vector<ShapeFreedom> freedom;
  for (const int h : others)
    if (h <= highest) freedom.push_back({EffectSpec(spec).set("harmonic", h)});
  return freedom;
}

}  // namespace mm
