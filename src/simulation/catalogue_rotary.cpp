// Errors of the rotary axes (ISO 230-7).
#include <Eigen/Geometry>
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"

namespace mm::source_kinds {
namespace {

int harmonicOf(const Making& m) { return std::stoi(m.source.key("harmonic")); }

/// A unit vector square to the joint's axis that goes round it, harmonic by harmonic, as the axis turns;
/// axes of workpiece with all joints at zero.
std::function<Eigen::Vector3d(const Condition&)> goingRound(const Making& m) {
  const int joint = m.joint("joint");
  const Eigen::Vector3d& axis = m.workshop.chain.axis(joint);
  const Eigen::Vector3d seed = std::abs(axis.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d first = (seed - axis * axis.dot(seed)).normalized(), second = axis.cross(first);
  return [=, harmonic = harmonicOf(m), phase = m.number("phase")](const Condition& c) -> Eigen::Vector3d {
    const double turn = harmonic * c.slide[joint] + phase;
    return std::cos(turn) * first + std::sin(turn) * second;
  };
}

}  // namespace

Kinds rotary() {
  return {
      {"rotary_zero",
       {{"joint", Key::kRotary}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       [](const Making& m) {
         m.add([j = m.joint("joint"), angle = m.number("angle")](const Condition&, Distortion& d) {
           d.travel[j] += angle;
         });
       }},
      // location errors: the axis does not stand where it should
      {"rotary_axis_offset",
       {{"joint", Key::kRotary}, {"direction", Key::kAcross}},
       {{"shift", "m", 3e-6, 30e-6, true}},
       [](const Making& m) {
         const Eigen::Vector3d shift = m.unitVector("direction") * m.number("shift");
         m.add([j = m.joint("joint"), shift](const Condition&, Distortion& d) { d.shift[j] += shift; });
       }},
      {"rotary_axis_tilt",
       {{"joint", Key::kRotary}, {"about", Key::kAcross}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       [](const Making& m) {
         const Eigen::Vector3d tilt = m.unitVector("about") * m.number("angle");
         m.add([j = m.joint("joint"), tilt](const Condition&, Distortion& d) { d.tilt[j] += tilt; });
       }},
      // an encoder disc mounted off its centre, in a bearing that runs out of true (radial motion)
      {"rotary_eccentricity",
       {{"joint", Key::kRotary}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond},
        {"phase", "turn", 0.01, 6.28},
        {"radial", "m", 1e-6, 6e-6}},
       [](const Making& m) {
         m.add([j = m.joint("joint"), harmonic = harmonicOf(m), angle = m.number("angle"),
                phase = m.number("phase"), radial = m.number("radial"),
                around = goingRound(m)](const Condition& c, Distortion& d) {
           d.travel[j] += std::asin(std::sin(angle) * std::sin(harmonic * c.drive[j] + phase));
           d.shift[j] += radial * around(c);
         });
       }},
      // the axis' direction wobbles as the bearing turns
      {"rotary_wobble",
       {{"joint", Key::kRotary}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond}, {"phase", "turn", 0.01, 6.28}},
       [](const Making& m) {
         m.add([j = m.joint("joint"), angle = m.number("angle"), around = goingRound(m)](
                   const Condition& c, Distortion& d) { d.tilt[j] += angle * around(c); });
       }},
  };
}

}  // namespace mm::source_kinds
