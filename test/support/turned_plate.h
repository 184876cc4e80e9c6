#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "session/session.h"

namespace mm::test {

/// Touches the balls of a plate that is turned between placements, with styli of its own. Lengths in m. The
/// contacts are made from geometry alone: nothing of the model is in them.
class TurnedPlate {
 public:
  /// Where the tip is beside the readings: readings (m), outward normal, stylus, day.
  using Error = std::function<Eigen::Vector3d(const Eigen::Vector3d&, const Eigen::Vector3d&, int, int)>;

  explicit TurnedPlate(unsigned seed) : random_(seed) {
    artifact.name = "plate";
    artifact.poseKnown = false;
    for (int i = 0; i < 9; ++i) {
      Feature ball;
      ball.name = "b" + std::to_string(i);
      ball.radius = 4e-3;
      ball.position = Eigen::Vector3d(12e-3 * (i % 3 - 1), 11e-3 * (i / 3 - 1), 3e-3 * ((i * 7) % 3 - 1));
      artifact.features.push_back(ball);
    }
    artifact.tipRadius = 1e-3;
  }

  Artifact artifact;  // as its file tells it
  /// Beside the file: of each ball; empty: none.
  std::vector<Eigen::Vector3d> deviation;
  std::vector<Eigen::Vector3d> offset = {Eigen::Vector3d::Zero()};  // of each stylus, true
  Error error = [](const auto&, const auto&, int, int) { return Eigen::Vector3d(0, 0, 0); };
  double noise = 0.2e-6;

  /// One session: at each angle (rad, about z) every stylus touches every ball. @param name of its source.
  /// @param named placements get the names "0", "90" …; else it stands in one without a name.
  Session session(const std::string& name, const std::vector<double>& angles, int day = 0,
                  bool named = true) {
    Session s(Machine::load("three_axis"));
    s.source = name;
    s.artifact = artifact;
    for (std::size_t p = 0; p < angles.size(); ++p) {
      const Eigen::Matrix3d turn = Eigen::AngleAxisd(angles[p], Eigen::Vector3d::UnitZ()).toRotationMatrix();
      const Eigen::Vector3d place(1e-4 * draw(), 10e-3 + 1e-4 * draw(), 1e-4 * draw());
      if (named) s.placements.push_back(std::to_string(std::lround(angles[p] / 0.017453292519943295)));
      for (std::size_t stylus = 0; stylus < offset.size(); ++stylus)
        for (std::size_t b = 0; b < artifact.features.size(); ++b) {
          Eigen::Vector3d centre = artifact.features[b].position;
          if (!deviation.empty()) centre += deviation[b];
          touch(turn * centre + place, static_cast<int>(b), static_cast<int>(stylus), static_cast<int>(p),
                day, s);
        }
    }
    s.prepare();
    return s;
  }

  double draw() { return normal_(random_); }

 private:
  void touch(const Eigen::Vector3d& centre, int ball, int stylus, int placement, int day, Session& s) {
    for (int k = 0; k < 13; ++k) {
      Eigen::Vector3d out;
      for (int c = 0; c < 3; ++c) out[c] = draw();
      out[2] = std::abs(out[2]);
      out.normalize();
      const double reach = artifact.features[static_cast<std::size_t>(ball)].radius +
                           artifact.tipRadiusOf(stylus) + noise * draw();
      const Eigen::Vector3d tip = centre + reach * out;
      Eigen::Vector3d q = tip - offset[static_cast<std::size_t>(stylus)];
      for (int i = 0; i < 4; ++i)
        q = tip - offset[static_cast<std::size_t>(stylus)] - error(q, out, stylus, day);
      Observation o;
      o.time = 2.0 * static_cast<double>(s.observations.size());
      o.row = static_cast<std::int64_t>(s.observations.size()) + 1;
      o.position = {q[0], q[1], q[2]};
      o.velocity = {-1e-3 * out[0], -1e-3 * out[1], -1e-3 * out[2]};
      o.approach = -out;
      o.feature = ball;
      o.stylus = stylus;
      o.placement = placement;
      s.observations.push_back(std::move(o));
    }
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace mm::test
