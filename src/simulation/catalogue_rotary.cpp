#include <Eigen/Geometry>
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"
#include "simulation/rotary.h"

namespace mm {
namespace {

using Key = SourceKind::Key;
using Probe = SourceKind::Probe;
using source_kinds::add;
using source_kinds::joint;
using source_kinds::unitVector;

/// Two unit vectors square to a joint's axis.
std::pair<Eigen::Vector3d, Eigen::Vector3d> across(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d seed = std::abs(axis.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d first = (seed - axis * axis.dot(seed)).normalized();
  return {first, axis.cross(first)};
}

}  // namespace

std::vector<SourceKind> rotaryKinds() {
  return {
      {"rotary_zero",
       {{"joint", Key::kRotary, ""}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<RotaryZero>(w, joint(s, w, "joint"), s.number("angle"));
       }},
      {"rotary_axis_offset",
       {{"joint", Key::kRotary, ""}, {"direction", Key::kAcross, ""}},
       {{"shift", "m", 3e-6, 30e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<RotaryLocation>(w, joint(s, w, "joint"), unitVector(s.key("direction")) * s.number("shift"),
                             Eigen::Vector3d::Zero());
       }},
      {"rotary_axis_tilt",
       {{"joint", Key::kRotary, ""}, {"about", Key::kAcross, ""}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<RotaryLocation>(w, joint(s, w, "joint"), Eigen::Vector3d::Zero(),
                             unitVector(s.key("about")) * s.number("angle"));
       }},
      {"rotary_eccentricity",
       {{"joint", Key::kRotary, ""}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond},
        {"phase", "turn", 0.01, 6.28},
        {"radial", "m", 1e-6, 6e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int j = joint(s, w, "joint");
         const auto [first, second] = across(w.chain.axis(j));
         add<DiscEccentricity>(w, j, std::stoi(s.key("harmonic")), s.number("angle"), s.number("phase"));
         add<RadialRunOut>(w, j, std::stoi(s.key("harmonic")), s.number("radial"), s.number("phase"), first,
                           second);
       }},
      {"rotary_wobble",
       {{"joint", Key::kRotary, ""}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond}, {"phase", "turn", 0.01, 6.28}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int j = joint(s, w, "joint");
         const auto [first, second] = across(w.chain.axis(j));
         add<Wobble>(w, j, std::stoi(s.key("harmonic")), s.number("angle"), s.number("phase"), first, second);
       }},
  };
}

}  // namespace mm
