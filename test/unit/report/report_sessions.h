#pragma once
#include <Eigen/Core>
#include <cmath>
#include <random>
#include <string>

#include "session/session.h"

namespace mm::test {

/// Deviations of x at nine targets, five runs up and down: `step` (m) either way, and noise (m).
inline Session interferometerSession(double step, double noise) {
  Session session(Machine::load("three_axis"));
  session.source = "interferometer.csv";
  std::mt19937 generator(4);
  std::normal_distribution<double> normal;
  double time = 0.0;
  for (int run = 0; run < 5; ++run)
    for (const double sign : {1.0, -1.0})
      for (int i = 0; i < 9; ++i) {
        Observation o;
        o.kind = ObservationKind::kDeviation;
        o.time = time += 10.0;
        o.row = static_cast<std::int64_t>(session.observations.size()) + 2;
        o.position = {sign * (-20e-3 + 5e-3 * i), 0.0, 0.0};
        o.velocity = {sign * 1e-3, 0.0, 0.0};
        o.deviation = {sign * step + noise * normal(generator), kNotMeasured, kNotMeasured};
        session.observations.push_back(o);
      }
  session.prepare();
  return session;
}

/// Contacts on one ball of 4 mm at (0, 10, 0) mm with a tip of 1 mm, found `outwards` (m) too far out
/// everywhere.
inline Session ballSession(const std::string& name, double outwards, double noise = 0.0) {
  Session session(Machine::load("three_axis"));
  session.source = "ball.csv";
  session.artifact.tipRadius = 1e-3;
  session.artifact.repeatability = 0.3e-6;
  Feature ball;
  ball.name = name;
  ball.position = {0.0, 10e-3, 0.0};
  ball.radius = 4e-3;
  session.artifact.features.push_back(ball);
  std::mt19937 generator(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 60; ++i) {
    const double z = 1.0 - (i + 0.5) / 45.0, turn = 2.39996 * i, s = std::sqrt(std::max(0.0, 1.0 - z * z));
    const Eigen::Vector3d n(s * std::cos(turn), s * std::sin(turn), z);
    const Eigen::Vector3d tip = ball.position + (5e-3 + outwards + noise * normal(generator)) * n;
    Observation o;
    o.time = 10.0 * i;
    o.row = i + 2;
    o.position = {tip.x(), tip.y(), tip.z()};
    const Eigen::Vector3d v = -2e-3 * n;
    o.velocity = {v.x(), v.y(), v.z()};
    o.approach = -n;
    o.feature = 0;
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

/// Readings of a laser of five_axis along its beam at one point, 3 to 9 mm by the height of its head, with
/// noise (m).
inline Session laserSession(double noise) {
  Session session(Machine::load("five_axis"));
  session.source = "laser.csv";
  std::mt19937 generator(6);
  std::normal_distribution<double> normal;
  const int joints = session.machine.jointCount(), z = session.machine.findJoint("z");
  const std::vector<double> zero(static_cast<std::size_t>(joints), 0.0);
  Feature point;
  point.kind = FeatureKind::kPoint;
  point.name = "target";
  point.position = session.machine.nominal(zero.data(), 6e-3).position;
  session.artifact.features.push_back(point);
  std::vector<double> up = zero;
  up[static_cast<std::size_t>(z)] = 1e-3;
  const double step = session.machine.nominal(up.data(), 6e-3).position.z() - point.position.z();
  const double beam = session.machine.nominal(zero.data(), 7e-3).position.z() - point.position.z();
  for (int i = 0; i < 40; ++i) {
    const double height = 3e-3 * (2.0 * i / 39.0 - 1.0);
    Observation o;
    o.time = 5.0 * i;
    o.row = i + 2;
    o.position = zero;
    o.position[static_cast<std::size_t>(z)] = height;
    o.velocity = zero;
    o.laserReading = 6e-3 - height * step / beam + noise * normal(generator);
    o.feature = 0;
    session.observations.push_back(o);
  }
  session.prepare();
  return session;
}

}  // namespace mm::test
