#include "uncertainty/rotation_tests.h"

#include <algorithm>
#include <optional>

#include "base/dense.h"
#include "base/format.h"
#include "base/range.h"
#include "base/units.h"
#include "uncertainty/circle_figures.h"
#include "uncertainty/setup_rows.h"

namespace mm {
namespace {

constexpr std::size_t kFewestAngles = 12;
constexpr double kShortestTurn = 150.0 * kDegree - 1e-6;
constexpr double kSmallestRadius = 1.0 * kMillimetre;  // a circle that is smaller has no direction
constexpr double kRestsAngle = 0.05 * kDegree;

using RotationRows = std::vector<int>;

/// Plane and circle by least squares through points (rows, m), and how far each is from them, um.
bool fitRotation(const Eigen::MatrixX3d& points, RotationTest& test) {
  const Eigen::RowVector3d mean = points.colwise().mean();
  const Eigen::MatrixX3d about = points.rowwise() - mean;
  const Eigen::Matrix3d axes = RightSingular(about).vectors;
  const Eigen::MatrixX3d in = about * axes;  // the last column is along the axis
  std::vector<Eigen::Vector2d> inPlane;
  for (Eigen::Index i = 0; i < in.rows(); ++i) inPlane.emplace_back(in(i, 0), in(i, 1));
  const Circle circle = leastSquaresCircle(inPlane);
  if (!(circle.radius >= kSmallestRadius)) return false;
  Range radial, axial;
  for (Eigen::Index i = 0; i < in.rows(); ++i) {
    const double out = (inPlane[i] - circle.centre).norm() - circle.radius;
    test.radial.push_back(out / kMicrometre);
    test.axial.push_back(in(i, 2) / kMicrometre);
    radial.add(test.radial.back());
    axial.add(test.axial.back());
  }
  test.radius = circle.radius / kMillimetre;
  test.radialError = radial.size();
  test.axialError = axial.size();
  return true;
}

std::optional<RotationTest> rotationOf(const Session& session, RotationRows rows, const ResidualOf& left) {
  const int joint = singleRotary(session, movedJoints(session, rows));
  if (joint < 0) return std::nullopt;
  const auto observation = [&](int i) -> const Observation& { return session.observations[i]; };
  const auto at = [&](int i) { return observation(i).position[joint]; };
  std::stable_sort(rows.begin(), rows.end(), [&](int a, int b) { return at(a) < at(b); });
  RotationTest test;
  std::size_t angles = 1;
  for (std::size_t i = 1; i < rows.size(); ++i) angles += at(rows[i]) - at(rows[i - 1]) > kRestsAngle;
  test.turn = at(rows.back()) - at(rows.front());
  if (angles < kFewestAngles || test.turn < kShortestTurn) return std::nullopt;
  Eigen::MatrixX3d points(rows.size(), 3);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Eigen::Vector3d point = observation(rows[k]).reference;
    if (left) {
      point = session.nominalProbe(observation(rows[k])).position;
      for (int c = 0; c < 3; ++c) point[c] += left(rows[k], c);
    }
    if (!point.allFinite()) return std::nullopt;
    points.row(k) = point;
    test.angle.push_back(at(rows[k]));
  }
  if (!fitRotation(points, test)) return std::nullopt;
  test.joint = session.machine.joints()[joint].name;
  return test;
}

}  // namespace

std::vector<RotationTest> rotationTests(const Session& session, const ResidualOf& left) {
  std::vector<RotationTest> tests;
  for (const SetupRows& group : rowsBySetup(session, ObservationKind::kPosition)) {
    RotationRows rows;
    for (const int i : group.observations)
      if (session.observations[i].reference.allFinite()) rows.push_back(i);
    if (rows.empty()) continue;
    if (std::optional<RotationTest> test = rotationOf(session, rows, left)) {
      test->setup = group.setup;
      tests.push_back(std::move(*test));
    }
  }
  return tests;
}

std::string inWords(const RotationTest& test) {
  return "ISO 230-7, axis of rotation " + test.joint + ": " + std::to_string(test.angle.size()) +
         format(" readings over %.0f deg", test.turn / kDegree);
}

}  // namespace mm
