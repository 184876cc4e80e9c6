// Errors of the linear axes: drives and guideways.
#include <array>
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"
#include "simulation/profile.h"
#include "simulation/screw.h"

namespace mm::source_kinds {
namespace {

/// The seven deviation constants of one axis, MMT equation (13), with the exponent 2 and the argument 2 pi.
void buildMmt(const Making& m) {
  const int axis = m.joint();
  std::vector<int> others;
  const std::vector<Joint>& joints = m.workshop.machine.joints();
  for (int j = 0; j < m.workshop.machine.jointCount(); ++j)
    if (j != axis && joints[j].kind == JointKind::kLinear) others.push_back(j);
  if (others.size() < 2) return;
  m.add([axis, others, position = m.number("C1"), amplitude = m.number("C2"), phase = m.number("phase"),
         lead = m.number("lead"), straightness = std::array{m.number("C_first"), m.number("C_second")},
         angle = std::array{m.number("alpha_first"), m.number("alpha_second")}](const Condition& c,
                                                                                Distortion& d) {
    const double q = c.drive[axis];
    double error = position * q + amplitude * q * std::sin(2.0 * kPi * q / lead + phase);
    for (std::size_t k = 0; k < 2; ++k) {
      const double other = c.drive[others[k]];
      error += straightness[k] * other * other + std::cos(0.5 * kPi + angle[k]) * other;
    }
    d.travel[axis] += error;
  });
}

}  // namespace

Kinds screw() {
  return {
      {"backlash",
       {{"axis", Key::kLinear}},
       {{"gap", "travel", 1e-6, 6e-6}},
       [](const Making& m) { m.workshop.physics.gap[m.joint()] += m.number("gap"); }},
      {"lead_screw_periodic",
       {{"axis", Key::kLinear}},
       {{"amplitude", "travel", 0.7e-6, 4e-6},
        {"period", "travel", 0.8e-3, 2.6e-3},
        {"phase", "turn", 0.01, 6.28}},
       [](const Making& m) {
         m.add(periodicLead(m.joint(), m.number("amplitude"), m.number("period"), m.number("phase")));
       }},
      // slow cumulated lead error of a screw or scale: the integral of a wandering lead
      {"positioning_polynomial",
       {{"axis", Key::kLinear}},
       {{"size", "travel", 1e-6, 6e-6}},
       [](const Making& m) {
         const int j = m.joint();
         m.add([j, profile = Profile::integratedWaves(m.workshop.lower[j], m.workshop.upper[j],
                                                      m.number("size"), m.random)](
                   const Condition& c, Distortion& d) { d.travel[j] += profile.at(c.drive[j]); });
       }},
      {"scale",
       {{"axis", Key::kLinear}},
       {{"s", "1", 60e-6, 400e-6, true}},
       [](const Making& m) {
         m.add([j = m.joint(), scale = m.number("s")](const Condition& c, Distortion& d) {
           d.travel[j] += scale * c.drive[j];
         });
       }},
      {"mmt_deviation",
       {{"axis", Key::kLinear}},
       {{"C1", "1", 50e-6, 300e-6, true},
        {"C2", "1", 50e-6, 200e-6},
        {"phase", "turn", 0.1, 6.2},
        {"C_first", "1/m", 0.002, 0.02, true},
        {"C_second", "1/m", 0.002, 0.02, true},
        {"alpha_first", "rad", 50e-6, 300e-6, true},
        {"alpha_second", "rad", 50e-6, 300e-6, true},
        {"lead", "m", 1e-3, 1e-3}},
       buildMmt,
       Probe::kAny,
       true},
  };
}

Kinds guideway() {
  return {
      // travel along `of` carries the tip along `axis`
      {"squareness",
       {{"axis", Key::kLinear}, {"of", Key::kOtherLinear}},
       {{"c", "rad", 60e-6, 400e-6, true}},
       [](const Making& m) {
         m.add([j = m.joint(), of = m.joint("of"), angle = m.number("c")](const Condition& c, Distortion& d) {
           d.travel[j] += std::tan(angle) * c.slide[of];
         });
       }},
      // the slide wanders sideways along its travel
      {"straightness",
       {{"axis", Key::kLinear}, {"direction", Key::kOtherDirection}},
       {{"size", "m", 1e-6, 6e-6}},
       [](const Making& m) {
         const int j = m.joint();
         m.add(
             [j, direction = m.direction(),
              profile = Profile::waves(m.workshop.lower[j], m.workshop.upper[j], m.number("size"), m.random)](
                 const Condition& c, Distortion& d) { direction.add(d, profile.at(c.slide[j])); });
       }},
      // roll, pitch or yaw of a slide along its travel (ISO 230-1)
      {"angular_motion",
       {{"axis", Key::kLinear}, {"about", Key::kAbout}, {"lever", Key::kWord, "workpiece"}},
       {{"size", "rad", 20.0 * kArcsecond, 80.0 * kArcsecond, true}},
       [](const Making& m) {
         const int j = m.joint();
         m.add(
             [j, tilt = m.tilt(),
              profile = Profile::rise(m.workshop.lower[j], m.workshop.upper[j], m.number("size"), m.random)](
                 const Condition& c, Distortion& d) { tilt.add(d, profile.at(c.slide[j])); });
       }},
      // a slide that tips where it reverses: half the angle to either side, behind its motion
      {"angular_reversal",
       {{"axis", Key::kLinear}, {"about", Key::kAbout}},
       {{"angle", "rad", 10.0 * kArcsecond, 60.0 * kArcsecond}},
       [](const Making& m) {
         m.add([j = m.joint(), tilt = m.tilt(), angle = m.number("angle")](
                   const Condition& c, Distortion& d) { tilt.add(d, -0.5 * angle * c.travel[j]); });
       },
       Probe::kAny,
       true},
  };
}

}  // namespace mm::source_kinds
