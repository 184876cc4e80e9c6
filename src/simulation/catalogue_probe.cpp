// Errors of probe and artifact.
#include <cmath>

#include "base/units.h"
#include "simulation/catalogue_parts.h"

namespace mm::source_kinds {
namespace {

int featureOf(const Making& m, const std::string& key) {
  return m.workshop.artifact.findFeature(m.source.key(key));
}

Eigen::Vector3d randomDirection(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return Eigen::Vector3d(x, y, z).normalized();
}

/// The laser's zero and beam stand differently in the head than the drawing says.
void buildLaserMount(const Making& m) {
  const Eigen::Vector3d zero = randomDirection(m.random) * m.number("zero");
  const double azimuth = m.random.uniform(0.0, 2.0 * kPi);
  const Eigen::Vector3d beam = Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0) * m.number("beam");
  m.add([zero, beam](const Condition&, Distortion& d) {
    d.probeShift += zero;
    d.beamTilt += beam;
  });
}

}  // namespace

Kinds probe() {
  return {
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
             m.number("size") * randomDirection(m.random);
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
  };
}

}  // namespace mm::source_kinds
