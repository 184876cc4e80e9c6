#include "simulation/catalogue.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"
#include "simulation/guideway.h"
#include "simulation/screw.h"
#include "simulation/structure.h"
#include "simulation/thermal.h"

namespace mm {
namespace {

using Key = SourceKind::Key;
using Probe = SourceKind::Probe;

using source_kinds::add;
using source_kinds::joint;
using source_kinds::unitVector;

/// A joint's own motion where a joint has that name, else the axis of workpiece.
Direction direction(const HiddenSource& s, const Workshop& w, const char* key) {
  const int j = w.machine.findJoint(s.key(key));
  if (j >= 0) return {j, -1};
  return {-1, s.key(key)[0] - 'x'};
}

Lever lever(const HiddenSource& s) { return s.key("lever") == "chain" ? Lever::kChain : Lever::kWorkpiece; }

int feature(const HiddenSource& s, const Workshop& w, const char* key) {
  return w.artifact.findFeature(s.key(key));
}

int covariate(const HiddenSource& s, const Workshop& w) {
  for (std::size_t c = 0; c < w.settings.covariates.size(); ++c)
    if (w.settings.covariates[c].name == s.key("covariate")) return static_cast<int>(c);
  return -1;
}

Eigen::Vector3d randomDirection(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

void buildMmt(const HiddenSource& s, Workshop& w, Random&) {
  std::vector<int> linear;
  const int axis = joint(s, w, "axis");
  for (int j = 0; j < w.machine.jointCount(); ++j)
    if (j != axis && w.machine.joints()[j].kind == JointKind::kLinear) linear.push_back(j);
  MmtAxis::Constants c;
  c.position = s.number("C1");
  c.lead = s.number("C2");
  c.phase = s.number("phase");
  c.straightness[0] = s.number("C_first");
  c.straightness[1] = s.number("C_second");
  c.angle[0] = s.number("alpha_first");
  c.angle[1] = s.number("alpha_second");
  if (linear.size() >= 2) add<MmtAxis>(w, axis, linear[0], linear[1], s.number("lead"), c);
}

std::vector<SourceKind> screwKinds() {
  return {
      {"backlash",
       {{"axis", Key::kLinear, ""}},
       {{"gap", "travel", 1e-6, 6e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         w.physics.gap[joint(s, w, "axis")] += s.number("gap");
       }},
      {"lead_screw_periodic",
       {{"axis", Key::kLinear, ""}},
       {{"amplitude", "travel", 0.7e-6, 4e-6},
        {"period", "travel", 0.8e-3, 2.6e-3},
        {"phase", "turn", 0.01, 6.28}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<PeriodicLead>(w, joint(s, w, "axis"), s.number("amplitude"), s.number("period"),
                           s.number("phase"));
       }},
      {"positioning_polynomial",
       {{"axis", Key::kLinear, ""}},
       {{"size", "travel", 1e-6, 6e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random& r) {
         const int j = joint(s, w, "axis");
         add<CumulatedLead>(w, j, Profile::integratedWaves(w.lower[j], w.upper[j], s.number("size"), r));
       }},
      {"scale",
       {{"axis", Key::kLinear, ""}},
       {{"s", "1", 60e-6, 400e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<ScaleError>(w, joint(s, w, "axis"), s.number("s"));
       }},
      {"mmt_deviation",
       {{"axis", Key::kLinear, ""}},
       {{"C1", "1", 50e-6, 300e-6, true},
        {"C2", "1", 50e-6, 200e-6},
        {"phase", "turn", 0.1, 6.2},
        {"C_first", "1/m", 0.002, 0.02, true},
        {"C_second", "1/m", 0.002, 0.02, true},
        {"alpha_first", "rad", 50e-6, 300e-6, true},
        {"alpha_second", "rad", 50e-6, 300e-6, true},
        {"lead", "m", 1e-3, 1e-3}},
       Probe::kAny,
       true,
       buildMmt},
  };
}

std::vector<SourceKind> guidewayKinds() {
  return {
      {"squareness",
       {{"axis", Key::kLinear, ""}, {"of", Key::kOtherLinear, ""}},
       {{"c", "rad", 60e-6, 400e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<Squareness>(w, joint(s, w, "axis"), joint(s, w, "of"), s.number("c"));
       }},
      {"straightness",
       {{"axis", Key::kLinear, ""}, {"direction", Key::kOtherDirection, ""}},
       {{"size", "m", 1e-6, 6e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random& r) {
         const int j = joint(s, w, "axis");
         add<Straightness>(
             w, j, direction(s, w, "direction"),
             Profile::waves(w.lower[j], w.upper[j], s.number("size"), Profile::Trend::kRemove, r));
       }},
      {"angular_motion",
       {{"axis", Key::kLinear, ""}, {"about", Key::kAbout, ""}, {"lever", Key::kWord, "workpiece"}},
       {{"size", "rad", 20.0 * kArcsecond, 80.0 * kArcsecond, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random& r) {
         const int j = joint(s, w, "axis");
         add<AngularMotion>(w, j, unitVector(s.key("about")), lever(s),
                            Profile::rise(w.lower[j], w.upper[j], s.number("size"), r));
       }},
      {"angular_reversal",
       {{"axis", Key::kLinear, ""}, {"about", Key::kAbout, ""}},
       {{"angle", "rad", 10.0 * kArcsecond, 60.0 * kArcsecond}},
       Probe::kAny,
       true,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<AngularReversal>(w, joint(s, w, "axis"), unitVector(s.key("about")), s.number("angle"));
       }},
  };
}

std::vector<SourceKind> structureKinds() {
  return {
      {"thermal_expansion",
       {{"axis", Key::kLinear, ""}, {"sensor", Key::kBody, ""}},
       {{"alpha", "1/K", 15e-6, 80e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<ThermalExpansion>(w, w.thermal.findBody(s.key("sensor")), joint(s, w, "axis"),
                               s.number("alpha"));
       }},
      {"thermal_growth",
       {{"direction", Key::kDirection, ""}, {"sensor", Key::kBody, ""}},
       {{"g", "m/K", 0.5e-6, 3e-6, true}, {"lag", "s", 0.0, 0.0}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         int body = w.thermal.findBody(s.key("sensor"));
         if (s.number("lag") >
             0.0) {  // a body of the structure that no sensor tells, behind the one that has it
           w.physics.followers.push_back({body, s.number("lag")});
           body = w.thermal.bodyCount() + static_cast<int>(w.physics.followers.size()) - 1;
         }
         add<ThermalGrowth>(w, body, direction(s, w, "direction"), s.number("g"));
       }},
      {"thermal_bending",
       {{"axis", Key::kLinear, ""},
        {"about", Key::kAbout, ""},
        {"warm", Key::kBody, ""},
        {"cold", Key::kColdBody, ""},
        {"lever", Key::kWord, "workpiece"}},
       {{"k", "rad/K", 4.0 * kArcsecond, 25.0 * kArcsecond, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<ThermalBending>(w, w.thermal.findBody(s.key("warm")), w.thermal.findBody(s.key("cold")),
                             joint(s, w, "axis"), unitVector(s.key("about")), lever(s), s.number("k"));
       }},
      {"time_drift",
       {{"direction", Key::kDirection, ""}},
       {{"d", "m/s", 2e-6 / 3600.0, 8e-6 / 3600.0, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<TimeDrift>(w, direction(s, w, "direction"), s.number("d"));
       }},
      {"jump",
       {{"direction", Key::kDirection, ""}},
       {{"d", "m", 2e-6, 8e-6, true}, {"at", "s", 300.0, 900.0}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<Slip>(w, direction(s, w, "direction"), s.number("d"), s.number("at"));
       }},
      {"warm_up",
       {{"direction", Key::kDirection, ""}},
       {{"d", "m", 3e-6, 12e-6, true}, {"tau", "s", 480.0, 1200.0}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         add<WarmUp>(w, direction(s, w, "direction"), s.number("d"), s.number("tau"));
       }},
      {"scale_warm_up",
       {{"axis", Key::kLinear, ""}},
       {{"strain", "1", 40e-6, 120e-6}, {"tau", "s", 480.0, 1200.0}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int j = joint(s, w, "axis");
         add<ScrewWarmUp>(w, j, w.lower[j], s.number("strain"), s.number("tau"));
       }},
      {"gravity_sag",
       {{"direction", Key::kDirection, "z"}, {"with", Key::kLinear, ""}},
       {{"drop", "m", 3e-6, 12e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int j = joint(s, w, "with");
         add<GravitySag>(w, j, direction(s, w, "direction"), w.lower[j], w.upper[j], s.number("drop"));
       }},
      {"covariate_offset",
       {{"direction", Key::kDirection, ""}, {"covariate", Key::kCovariate, ""}},
       {{"k", "m", 0.2e-6, 0.8e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int c = covariate(s, w);
         add<CovariateError>(w, c, w.settings.covariates[c].mean, direction(s, w, "direction"), -1,
                             s.number("k"));
       }},
      {"covariate_scale",
       {{"axis", Key::kLinear, ""}, {"covariate", Key::kCovariate, ""}},
       {{"k", "1", 15e-6, 60e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         const int c = covariate(s, w), j = joint(s, w, "axis");
         add<CovariateError>(w, c, w.settings.covariates[c].mean, Direction{j, -1}, j, s.number("k"));
       }},
  };
}

std::vector<SourceKind> probeKinds() {
  return {
      {"speed_lag",
       {},
       {{"tau", "s", 0.3e-3, 2e-3}},
       Probe::kTouch,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) { w.physics.probe.triggerDelay += s.number("tau"); }},
      {"probe_lobing",
       {{"order", Key::kWord, "3"}},
       {{"size", "m", 0.6e-6, 3e-6}, {"phase", "turn", 0.01, 6.28}},
       Probe::kTouch,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         w.physics.probe.setLobing(std::stoi(s.key("order")), s.number("size"), s.number("phase"));
       }},
      {"probe_radius",
       {},
       {{"size", "m", 1e-6, 6e-6, true}},
       Probe::kTouch,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) { w.physics.probe.radiusError += s.number("size"); }},
      {"tip_wear",
       {},
       {{"size", "m/s", 2e-6 / 3600.0, 8e-6 / 3600.0, true}},
       Probe::kTouch,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) { w.physics.probe.wear += s.number("size"); }},
      {"ball_radius",
       {{"ball", Key::kBall, ""}},
       {{"size", "m", 1e-6, 5e-6, true}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         w.physics.artifact.radiusError[feature(s, w, "ball")] += s.number("size");
       }},
      {"artifact_position",
       {{"feature", Key::kBall, ""}},
       {{"size", "m", 2e-6, 8e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random& r) {
         w.physics.artifact.shift[feature(s, w, "feature")] += s.number("size") * randomDirection(r);
       }},
      {"artifact_expansion",
       {},
       {{"alpha", "1/K", 15e-6, 60e-6}},
       Probe::kAny,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) {
         w.physics.artifact.expansion += s.number("alpha");
       }},
      {"laser_mount",
       {},
       {{"zero", "m", 20e-6, 300e-6}, {"beam", "rad", 1e-3, 20e-3}},
       Probe::kLaser,
       false,
       [](const HiddenSource& s, Workshop& w, Random& r) {
         const Eigen::Vector3d zero = randomDirection(r) * s.number("zero");
         const double azimuth = r.uniform(0.0, 2.0 * kPi);
         add<LaserMount>(w, zero,
                         Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0) * s.number("beam"));
       }},
      {"laser_scale",
       {},
       {{"s", "1", 1e-3, 5e-3, true}},
       Probe::kLaser,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) { w.physics.laser.scale += s.number("s"); }},
      {"laser_incidence",
       {},
       {{"size", "m", 2e-6, 12e-6, true}},
       Probe::kLaser,
       false,
       [](const HiddenSource& s, Workshop& w, Random&) { w.physics.laser.incidence += s.number("size"); }},
  };
}

}  // namespace

const std::vector<SourceKind>& sourceKinds() {
  static const std::vector<SourceKind> kinds = [] {
    std::vector<SourceKind> all;
    for (const auto& group : {screwKinds(), guidewayKinds(), structureKinds(), probeKinds(), rotaryKinds()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return kinds;
}

}  // namespace mm
