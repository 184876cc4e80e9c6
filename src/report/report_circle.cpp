#include <Eigen/Core>
#include <array>
#include <cmath>
#include <map>

#include "base/units.h"
#include "report/iso_tests.h"
#include "uncertainty/residual_of.h"

namespace mm {
namespace {

constexpr const char* kBallBar = "ball_bar";  // the artifact that mm import makes of one

/// The circle of one imported ball bar: the tip was further out than the nominal circle by as much as the
/// reading was nearer. @param first, second of its axes, on return.
std::vector<CirclePlace> circleOfBar(const Session& session, const ResidualOf& left, int feature, int& first,
                                     int& second) {
  const Feature& bar = session.artifact.features[static_cast<std::size_t>(feature)];
  // of each reading: from the centre to the tip (m, workpiece), and the radial deviation that is left (um)
  std::vector<std::pair<Eigen::Vector3d, double>> rows;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.kind != ObservationKind::kContact || o.feature != feature) continue;
    const Eigen::Vector3d out =
        session.machine.nominal(o.position.data(), kNotMeasured).position - bar.position;
    const double rest = -left(static_cast<int>(i), 0) / kMicrometre;
    if (!(out.norm() > 0.0) || !std::isfinite(rest)) continue;
    squares += out.cwiseAbs2();
    rows.emplace_back(out, rest);
  }
  int normal = 0;
  squares.minCoeff(&normal);
  first = (normal + 1) % 3;
  second = (normal + 2) % 3;
  const auto in = [&](const Eigen::Vector3d& v) { return Eigen::Vector2d(v[first], v[second]); };
  std::vector<CirclePlace> places;
  for (const auto& [out, rest] : rows) {
    const Eigen::Vector3d outwards = out.normalized();
    const double deviation = (bar.radius - out.norm()) / kMicrometre;
    places.push_back({in(bar.position + bar.radius * outwards) / kMillimetre, deviation * in(outwards),
                      rest * in(outwards)});
  }
  return places;
}

}  // namespace

std::vector<CircleTest> circleTests(const CalibrationResult& fitted) {
  const Problem& problem = *fitted.problem;
  const Session& session = problem.session();
  const std::vector<Joint>& joints = session.machine.joints();
  const ResidualOf left = residualsOf(fitted);
  std::vector<CircleTest> tests;
  const auto add = [&](const std::map<int, std::vector<CirclePlace>>& bySetup, const std::string& first,
                       const std::string& second) {
    for (const auto& [setup, places] : bySetup)
      if (std::optional<CircleTest> test = circleTest(places)) {
        test->first = first;
        test->second = second;
        if (bySetup.size() > 1 && setup >= 0) test->setup = session.setups[static_cast<std::size_t>(setup)];
        tests.push_back(std::move(*test));
      }
  };
  /// @param placeOf of an observation and its index; lengths in m.
  const auto addPlane = [&](ObservationKind kind, const std::string& first, const std::string& second,
                            const auto& placeOf) {
    std::map<int, std::vector<CirclePlace>> bySetup;
    for (std::size_t i = 0; i < session.observations.size(); ++i) {
      const Observation& o = session.observations[i];
      if (o.kind != kind) continue;
      const CirclePlace p = placeOf(o, static_cast<int>(i));
      if (p.measured.allFinite() && p.left.allFinite())
        bySetup[o.setup].push_back({p.nominal / kMillimetre, p.measured / kMicrometre, p.left / kMicrometre});
    }
    add(bySetup, first, second);
  };
  std::vector<int> linear;
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (joints[j].kind == JointKind::kLinear) linear.push_back(static_cast<int>(j));
  const std::size_t planes = linear.size() > 2 ? linear.size() : linear.size() / 2;
  for (std::size_t k = 0; k < planes; ++k) {
    const int a = linear[k], b = linear[(k + 1) % linear.size()];
    const auto ja = static_cast<std::size_t>(a), jb = static_cast<std::size_t>(b);
    addPlane(ObservationKind::kDeviation, joints[ja].name, joints[jb].name,
             [&](const Observation& o, int i) -> CirclePlace {
               return {{o.position[ja], o.position[jb]},
                       {o.deviation[ja], o.deviation[jb]},
                       {left(i, a), left(i, b)}};
             });
  }
  const std::array<const char*, 3> axes = {"x", "y", "z"};
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    addPlane(ObservationKind::kPosition, axes[static_cast<std::size_t>(a)], axes[static_cast<std::size_t>(b)],
             [&](const Observation& o, int i) -> CirclePlace {
               const double reading = std::isfinite(o.laserReading) ? o.laserReading : 0.0;
               const Eigen::Vector3d tip = session.machine.nominal(o.position.data(), reading).position;
               Eigen::Vector3d at = o.reference, rest(left(i, 0), left(i, 1), left(i, 2));
               if (problem.poseFree(o.placement)) {  // takes all three components
                 const Eigen::Matrix3d rotation = problem.artifactRotation(o.placement, fitted.x);
                 at = rotation * at;
                 rest = rotation * rest;
               }
               return {{tip[a], tip[b]}, {at[a] - tip[a], at[b] - tip[b]}, {rest[a], rest[b]}};
             });
  }
  if (session.artifact.name != kBallBar || !session.artifact.poseKnown) return tests;
  for (int f = 0; f < static_cast<int>(session.artifact.features.size()); ++f) {
    int first = 0, second = 0;
    const std::vector<CirclePlace> places = circleOfBar(session, left, f, first, second);
    add({{-1, places}}, axes[static_cast<std::size_t>(first)], axes[static_cast<std::size_t>(second)]);
  }
  return tests;
}

}  // namespace mm
