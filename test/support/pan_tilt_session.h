#pragma once
#include <functional>

#include "base/units.h"
#include "random_numbers.h"
#include "session/session.h"

namespace mm::test_support {

/// A mount of two rotary axes, its line of sight along x at zero; positive tilt looks up.
inline Machine panTilt() {
  return Machine(R"(<robot name="pan_tilt">
  <link name="workpiece"/><link name="fork"/><link name="tube"/><link name="probe_tip"/>
  <joint name="pan" type="revolute"><parent link="workpiece"/><child link="fork"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-3.2" upper="3.2" effort="1" velocity="1"/></joint>
  <joint name="tilt" type="revolute"><parent link="fork"/><child link="tube"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 -1 0"/><limit lower="-0.2" upper="1.6" effort="1" velocity="1"/></joint>
  <joint name="tip" type="fixed"><parent link="tube"/><child link="probe_tip"/><origin xyz="0.5 0 0"/></joint>
</robot>)",
                 "pan_tilt");
}

/// True minus indicated of both axes, arcsec, at the readings `pan` and `tilt` (rad).
using PanTiltError = std::function<std::pair<double, double>(double pan, double tilt)>;

/// Directions all over the upper hemisphere, each measured once. @param noise standard deviation, arcsec.
inline Session panTiltSession(int count, double noise, std::uint64_t seed, const PanTiltError& error) {
  Session session(panTilt());
  session.source = "pan_tilt";
  RandomNumbers random(seed);
  for (int i = 0; i < count; ++i) {
    Observation o;
    o.kind = ObservationKind::kDeviation;
    o.time = 20.0 * i;
    o.row = i + 2;
    o.position = {random.uniform(-170, 170) * kDegree, random.uniform(8, 82) * kDegree};
    o.velocity.assign(2, kNotMeasured);
    o.deviationStd.assign(2, kNotMeasured);
    const auto [pan, tilt] = error(o.position[0], o.position[1]);
    o.deviation = {(pan + random.normal(noise)) * kArcsecond, (tilt + random.normal(noise)) * kArcsecond};
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

}  // namespace mm::test_support
