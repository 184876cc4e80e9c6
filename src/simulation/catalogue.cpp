#include "simulation/catalogue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/units.h"
#include "simulation/profile.h"
#include "simulation/screw.h"
#include "simulation/setting.h"

namespace mm {
namespace {

using Key = SourceKind::Key;
using Probe = SourceKind::Probe;
using Build = std::function<void(const Making&)>;

Build law(SourceLaw of) {
  return [of = std::move(of)](const Making& m) { m.add(of); };
}

/// A law along a random curve over the travel of the key `axis`. @param make of Profile. @param at where on
/// the curve: by the drive or by the slide.
Build alongTravel(Profile (*make)(double, double, double, Random&), std::vector<double> Condition::*at,
                  void (*act)(const Instant&, double error, Distortion&)) {
  return [=](const Making& m) {
    const int j = m.joint();
    m.add([=, profile = make(m.workshop.lower[j], m.workshop.upper[j], m.number("size"), m.random)](
              const Instant& i, Distortion& d) { act(i, profile.at((i.now.*at)[j]), d); });
  };
}

/// The seven deviation constants of one axis, MMT equation (13), with the exponent 2 and the argument 2 pi.
void buildMmt(const Making& m) {
  const int axis = m.joint();
  std::vector<int> others;
  const std::vector<Joint>& joints = m.workshop.machine.joints();
  for (int j = 0; j < m.workshop.machine.jointCount(); ++j)
    if (j != axis && joints[j].kind == JointKind::kLinear) others.push_back(j);
  if (others.size() < 2) return;
  m.add([axis, others](const Instant& i, Distortion& d) {
    const double q = i.drive();
    double error = i.number("C1") * q +
                   i.number("C2") * q * std::sin(2.0 * kPi * q / i.number("lead") + i.number("phase"));
    const std::array straightness = {i.number("C_first"), i.number("C_second")},
                     angle = {i.number("alpha_first"), i.number("alpha_second")};
    for (std::size_t k = 0; k < 2; ++k) {
      const double other = i.now.drive[others[k]];
      error += straightness[k] * other * other + std::cos(0.5 * kPi + angle[k]) * other;
    }
    d.travel[axis] += error;
  });
}

/// The body of the key `sensor`; with the number `lag` one that no sensor tells, behind the one that has it.
int bodyOf(const Making& m) {
  const int body = m.workshop.thermal.findBody(m.source.key("sensor"));
  if (m.number("lag") <= 0.0) return body;
  std::vector<Follower>& followers = m.workshop.physics.followers;
  followers.push_back({body, m.number("lag")});
  return m.workshop.thermal.bodyCount() + static_cast<int>(followers.size()) - 1;
}

/// A screw or scale expands from its fixed end, which is at the axis' zero.
void buildExpansion(const Making& m) {
  m.add([body = bodyOf(m)](const Instant& i, Distortion& d) {
    d.travel[i.joint()] += i.number("alpha") * i.drive() * (i.now.bodies[body] - kReferenceTemperature);
  });
}

void buildGrowth(const Making& m) {
  m.add([body = bodyOf(m)](const Instant& i, Distortion& d) {
    i.direction().add(d, i.number("g") * (i.now.bodies[body] - kReferenceTemperature));
  });
}

int featureOf(const Making& m, const std::string& key) {
  return m.workshop.artifact.findFeature(m.source.key(key));
}

/// The laser's zero and beam stand differently in the head than the drawing says.
void buildLaserMount(const Making& m) {
  const Eigen::Vector3d zero = randomVector(m.random).normalized() * m.number("zero");
  const double azimuth = m.random.uniform(0.0, 2.0 * kPi);
  const Eigen::Vector3d beam = Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0) * m.number("beam");
  m.add([zero, beam](const Instant&, Distortion& d) {
    d.probeShift += zero;
    d.beamTilt += beam;
  });
}

int harmonicOf(const Instant& i) { return std::stoi(i.setting.source.key("harmonic")); }

/// A unit vector square to the joint's axis that goes round it, harmonic by harmonic, as the axis turns;
/// axes of workpiece with all joints at zero.
Eigen::Vector3d goingRound(const Instant& i) {
  const Eigen::Vector3d& axis = i.setting.axes[i.joint("joint")];
  const Eigen::Vector3d seed = std::abs(axis.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d first = (seed - axis * axis.dot(seed)).normalized(), second = axis.cross(first);
  const double turn = harmonicOf(i) * i.slide("joint") + i.number("phase");
  return std::cos(turn) * first + std::sin(turn) * second;
}

std::vector<SourceKind> makeKinds() {
  return {
      // of the drives: positions along the axis
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
         m.workshop.physics.sources.push_back(
             periodicLead(m.joint(), m.number("amplitude"), m.number("period"), m.number("phase")));
       }},
      // slow cumulated lead error of a screw or scale: the integral of a wandering lead
      {"positioning_polynomial",
       {{"axis", Key::kLinear}},
       {{"size", "travel", 1e-6, 6e-6}},
       alongTravel(Profile::integratedWaves, &Condition::drive,
                   [](const Instant& i, double error, Distortion& d) { d.travel[i.joint()] += error; })},
      {"scale",
       {{"axis", Key::kLinear}},
       {{"s", "1", 60e-6, 400e-6, true}},
       law([](const Instant& i, Distortion& d) { d.travel[i.joint()] += i.number("s") * i.drive(); })},
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

      // of the guideways; travel along `of` carries the tip along `axis`
      {"squareness",
       {{"axis", Key::kLinear}, {"of", Key::kOtherLinear}},
       {{"c", "rad", 60e-6, 400e-6, true}},
       law([](const Instant& i, Distortion& d) {
         d.travel[i.joint()] += std::tan(i.number("c")) * i.slide("of");
       })},
      // the slide wanders sideways along its travel
      {"straightness",
       {{"axis", Key::kLinear}, {"direction", Key::kOtherDirection}},
       {{"size", "m", 1e-6, 6e-6}},
       alongTravel(Profile::waves, &Condition::slide,
                   [](const Instant& i, double error, Distortion& d) { i.direction().add(d, error); })},
      // roll, pitch or yaw of a slide along its travel (ISO 230-1)
      {"angular_motion",
       {{"axis", Key::kLinear}, {"about", Key::kAbout}, {"lever", Key::kWord, "workpiece"}},
       {{"size", "rad", 20.0 * kArcsecond, 80.0 * kArcsecond, true}},
       alongTravel(Profile::rise, &Condition::slide,
                   [](const Instant& i, double error, Distortion& d) { i.tilt().add(d, error); })},
      // a slide that tips where it reverses: half the angle to either side, behind its motion
      {"angular_reversal",
       {{"axis", Key::kLinear}, {"about", Key::kAbout}},
       {{"angle", "rad", 10.0 * kArcsecond, 60.0 * kArcsecond}},
       law([](const Instant& i, Distortion& d) {
         i.tilt().add(d, -0.5 * i.number("angle") * i.now.travel[i.joint()]);
       }),
       Probe::kAny,
       true},
      // one that shifts aside where it reverses
      {"straightness_reversal",
       {{"axis", Key::kLinear}, {"direction", Key::kOtherDirection}},
       {{"step", "m", 1e-6, 5e-6}},
       law([](const Instant& i, Distortion& d) {
         i.direction().add(d, -0.5 * i.number("step") * i.now.travel[i.joint()]);
       }),
       Probe::kAny,
       true},

      // friction drags a carriage askew, with the arm at which the tip stands
      {"friction_lever",
       {{"axis", Key::kLinear}, {"across", Key::kOtherLinear}},
       {{"angle", "rad", 60.0 * kArcsecond, 200.0 * kArcsecond, true}},
       law([](const Instant& i, Distortion& d) {
         const int j = i.joint();
         d.travel[j] += 0.5 * i.number("angle") * i.now.travel[j] * i.position("across");
       }),
       Probe::kAny,
       true},

      // of heat
      {"thermal_expansion",
       {{"axis", Key::kLinear}, {"sensor", Key::kBody}},
       {{"alpha", "1/K", 15e-6, 80e-6}, {"lag", "s", 0.0, 0.0}},
       buildExpansion},
      {"thermal_growth",
       {{"direction", Key::kDirection}, {"sensor", Key::kBody}},
       {{"g", "m/K", 0.5e-6, 3e-6, true}, {"lag", "s", 0.0, 0.0}},
       buildGrowth},
      // a column warmer on one side than on the other bends and tips what it carries
      {"thermal_bending",
       {{"axis", Key::kLinear},
        {"about", Key::kAbout},
        {"warm", Key::kBody},
        {"cold", Key::kColdBody},
        {"lever", Key::kWord, "workpiece"}},
       {{"k", "rad/K", 4.0 * kArcsecond, 25.0 * kArcsecond, true}},
       law([](const Instant& i, Distortion& d) {
         i.tilt().add(d, i.number("k") * (i.temperature("warm") - i.temperature("cold")));
       })},

      // of time
      {"time_drift",
       {{"direction", Key::kDirection}},
       {{"d", "m/s", 2e-6 / 3600.0, 8e-6 / 3600.0, true}},
       law([](const Instant& i, Distortion& d) { i.direction().add(d, i.number("d") * i.now.time); })},
      // a clamp that slips, and gives way a little after it
      {"jump",
       {{"direction", Key::kDirection}},
       {{"d", "m", 2e-6, 8e-6, true}, {"at", "s", 300.0, 900.0}},
       law([](const Instant& i, Distortion& d) {
         constexpr double kAfter = 0.05, kSettles = 120.0;  // of the size; s
         const double since = i.now.time - i.number("at");
         if (since >= 0.0)
           i.direction().add(d, i.number("d") * (1.0 - kAfter * std::expm1(-since / kSettles)));
       })},
      // after switching on a fast and a slow part of the structure come to their temperatures
      {"warm_up",
       {{"direction", Key::kDirection}},
       {{"d", "m", 3e-6, 12e-6, true}, {"tau", "s", 480.0, 1200.0}},
       law([](const Instant& i, Distortion& d) {
         constexpr double kFast = 0.1, kFaster = 5.0;  // share of the fast part
         const double t = i.now.time / i.number("tau");
         i.direction().add(
             d, i.number("d") * ((1.0 - kFast) * -std::expm1(-t) + kFast * -std::expm1(-kFaster * t)));
       })},
      // a screw that heats itself by running grows from its fixed bearing
      {"scale_warm_up",
       {{"axis", Key::kLinear}},
       {{"strain", "1", 40e-6, 120e-6}, {"tau", "s", 480.0, 1200.0}},
       law([](const Instant& i, Distortion& d) {
         const int j = i.joint();
         d.travel[j] += i.number("strain") * -std::expm1(-i.now.time / i.number("tau")) *
                        (i.drive() - i.setting.lower[j]);
       })},

      // of loads, and of what was logged; a ram that sags as it extends: a cantilever under a load at its end
      // and its own weight
      {"gravity_sag",
       {{"direction", Key::kDirection, "z"}, {"with", Key::kLinear}},
       {{"drop", "m", 3e-6, 12e-6}},
       law([](const Instant& i, Distortion& d) {
         // end load P e^3 / (3 E I), own weight w e^4 / (8 E I): here nine parts to one at full extension
         constexpr double kOwnWeight = 0.1;
         const int j = i.joint("with");
         const double retracted = i.setting.lower[j], length = i.setting.upper[j] - retracted;
         const double e = std::max(0.0, (i.slide("with") - retracted) / length);
         i.direction().add(d, -i.number("drop") * e * e * e * ((1.0 - kOwnWeight) + kOwnWeight * e));
       })},
      {"covariate_offset",
       {{"direction", Key::kDirection}, {"covariate", Key::kCovariate}},
       {{"k", "m", 0.2e-6, 0.8e-6, true}},
       law([](const Instant& i, Distortion& d) {
         i.direction().add(d, i.number("k") * i.change("covariate"));
       })},
      {"covariate_scale",
       {{"axis", Key::kLinear}, {"covariate", Key::kCovariate}},
       {{"k", "1", 15e-6, 60e-6, true}},
       law([](const Instant& i, Distortion& d) {
         d.travel[i.joint()] += i.number("k") * i.change("covariate") * i.drive();
       })},

      // of probe and artifact
      {"speed_lag",
       {},
       {{"tau", "s", 0.3e-3, 2e-3}},
       [](const Making& m) { m.workshop.physics.probe.triggerDelay += m.number("tau"); },
       Probe::kTouch},
      {"probe_lobing",
       {{"order", Key::kWord, "3"}},
       {{"size", "m", 0.6e-6, 3e-6}, {"phase", "turn", 0.01, 6.28}},
       [](const Making& m) {
         m.workshop.physics.probe.setLobing(std::stoi(m.source.key("order")), m.number("size"),
                                            m.number("phase"));
       },
       Probe::kTouch},
      {"probe_radius",
       {},
       {{"size", "m", 1e-6, 6e-6, true}},
       [](const Making& m) { m.workshop.physics.probe.radiusError += m.number("size"); },
       Probe::kTouch},
      // a stylus that was changed: it matters where a rotary axis turns the probe
      {"tip_offset",
       {},
       {{"x", "m", 5e-6, 30e-6, true}, {"y", "m", 5e-6, 30e-6, true}, {"z", "m", 5e-6, 30e-6, true}},
       law([](const Instant& i, Distortion& d) {
         d.probeShift += Eigen::Vector3d(i.number("x"), i.number("y"), i.number("z"));
       }),
       Probe::kTouch,
       true},
      {"tip_wear",
       {},
       {{"size", "m/s", 2e-6 / 3600.0, 8e-6 / 3600.0, true}},
       [](const Making& m) { m.workshop.physics.probe.wear += m.number("size"); },
       Probe::kTouch},
      {"ball_radius",
       {{"ball", Key::kBall}},
       {{"size", "m", 1e-6, 5e-6, true}},
       [](const Making& m) {
         m.workshop.physics.artifact.radiusError[featureOf(m, "ball")] += m.number("size");
       }},
      {"artifact_position",
       {{"feature", Key::kBall}},
       {{"size", "m", 2e-6, 8e-6}},
       [](const Making& m) {
         m.workshop.physics.artifact.shift[featureOf(m, "feature")] +=
             m.number("size") * randomVector(m.random).normalized();
       }},
      {"artifact_expansion",
       {},
       {{"alpha", "1/K", 15e-6, 60e-6}},
       [](const Making& m) { m.workshop.physics.artifact.expansion += m.number("alpha"); }},
      {"laser_mount",
       {},
       {{"zero", "m", 20e-6, 300e-6}, {"beam", "rad", 1e-3, 20e-3}},
       buildLaserMount,
       Probe::kLaser},
      {"laser_scale",
       {},
       {{"s", "1", 1e-3, 5e-3, true}},
       [](const Making& m) { m.workshop.physics.laser.scale += m.number("s"); },
       Probe::kLaser},
      {"laser_incidence",
       {},
       {{"size", "m", 2e-6, 12e-6, true}},
       [](const Making& m) { m.workshop.physics.laser.incidence += m.number("size"); },
       Probe::kLaser},

      // of the rotary axes (ISO 230-7)
      {"rotary_zero",
       {{"joint", Key::kRotary}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       law([](const Instant& i, Distortion& d) { d.travel[i.joint("joint")] += i.number("angle"); })},
      // location errors: the axis does not stand where it should
      {"rotary_axis_offset",
       {{"joint", Key::kRotary}, {"direction", Key::kAcross}},
       {{"shift", "m", 3e-6, 30e-6, true}},
       law([](const Instant& i, Distortion& d) {
         d.shift[i.joint("joint")] += i.unitVector("direction") * i.number("shift");
       })},
      {"rotary_axis_tilt",
       {{"joint", Key::kRotary}, {"about", Key::kAcross}},
       {{"angle", "rad", 5.0 * kArcsecond, 60.0 * kArcsecond, true}},
       law([](const Instant& i, Distortion& d) {
         d.tilt[i.joint("joint")] += i.unitVector("about") * i.number("angle");
       })},
      // an encoder disc mounted off its centre, in a bearing that runs out of true (radial motion)
      {"rotary_eccentricity",
       {{"joint", Key::kRotary}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond},
        {"phase", "turn", 0.01, 6.28},
        {"radial", "m", 1e-6, 6e-6}},
       law([](const Instant& i, Distortion& d) {
         const int j = i.joint("joint");
         const double turn = harmonicOf(i) * i.drive("joint") + i.number("phase");
         d.travel[j] += std::asin(std::sin(i.number("angle")) * std::sin(turn));
         d.shift[j] += i.number("radial") * goingRound(i);
       })},
      // the axis' direction wobbles as the bearing turns
      {"rotary_wobble",
       {{"joint", Key::kRotary}, {"harmonic", Key::kWord, "1"}},
       {{"angle", "rad", 4.0 * kArcsecond, 40.0 * kArcsecond}, {"phase", "turn", 0.01, 6.28}},
       law([](const Instant& i, Distortion& d) {
         d.tilt[i.joint("joint")] += i.number("angle") * goingRound(i);
       })},
  };
}

}  // namespace

const std::vector<SourceKind>& sourceKinds() {
  static const std::vector<SourceKind> kinds = makeKinds();
  return kinds;
}

}  // namespace mm
