#include "report/report_circle.h"

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <map>

#include "base/units.h"
#include "uncertainty/residual_of.h"

namespace mm {
namespace {

constexpr const char* kBallBar = "ball_bar";  // the artifact that mm import makes of one

/// A row of an imported ball bar: the reading at which the tip was at the nominal radius from the centre.
struct BarRow {
  int feature = 0;
  Eigen::Vector3d centre, out;      // m; out: from the centre to the tip, in workpiece
  double radius = 0.0, left = 0.0;  // m, nominal; um, radial deviation that the model leaves
};

std::vector<BarRow> barRows(const Session& session, const ResidualOf& left) {
  std::vector<BarRow> rows;
  if (session.artifact.name != kBallBar || !session.artifact.poseKnown) return rows;
  for (std::size_t i = 0; i < session.observations.size(); ++i) {
    const Observation& o = session.observations[i];
    if (o.kind != ObservationKind::kContact || o.feature < 0) continue;
    const Feature& bar = session.artifact.features[static_cast<std::size_t>(o.feature)];
    const Eigen::Vector3d tip = session.machine.nominal(o.position.data(), kNotMeasured).position;
    const BarRow row{o.feature, bar.position, tip - bar.position, bar.radius,
                     -left(static_cast<int>(i), 0) / kMicrometre};
    if (row.out.norm() > 0.0 && std::isfinite(row.left)) rows.push_back(row);
  }
  return rows;
}

/// The circle of one ball bar: the tip was further out than the nominal circle by as much as the reading was
/// nearer. @param first, second of its axes, on return.
std::vector<CirclePlace> circleOfBar(const std::vector<BarRow>& rows, int feature, int& first, int& second) {
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const BarRow& row : rows)
    if (row.feature == feature) squares += row.out.cwiseAbs2();
  int normal = 0;
  squares.minCoeff(&normal);
  first = (normal + 1) % 3;
  second = (normal + 2) % 3;
  const auto in = [&](const Eigen::Vector3d& v) { return Eigen::Vector2d(v[first], v[second]); };
  std::vector<CirclePlace> places;
  for (const BarRow& row : rows) {
    if (row.feature != feature) continue;
    const Eigen::Vector3d outwards = row.out.normalized();
    const double deviation = (row.radius - row.out.norm()) / kMicrometre;
    places.push_back({in(row.centre + row.radius * outwards) / kMillimetre, deviation * in(outwards),
                      row.left * in(outwards)});
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
  const std::vector<BarRow> bars = barRows(session, left);
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    int first = 0, second = 0;
    std::map<int, std::vector<CirclePlace>> places;
    places[-1] = circleOfBar(bars, static_cast<int>(f), first, second);
    if (!places[-1].empty())
      add(places, axes[static_cast<std::size_t>(first)], axes[static_cast<std::size_t>(second)]);
  }
  return tests;
}

}  // namespace mm
