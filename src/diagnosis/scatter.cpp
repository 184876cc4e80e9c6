// What scatters in every session of balls, and is no cause: their centres, radii and form.
#include <Eigen/Dense>
#include <cmath>

#include "diagnosis/search.h"

namespace mm {
namespace {

constexpr double kPrice = 3.0;  // nats: as for a drift term
constexpr std::size_t kMostBalls =
    40;  // more are treated as free of scatter: their columns would be too many

/// Real spherical harmonics of degree 2 and 3 at a unit vector, each of unit mean square over the sphere.
Eigen::Matrix<double, 12, 1> harmonics(const Eigen::Vector3d& n) {
  const double x = n.x(), y = n.y(), z = n.z();
  Eigen::Matrix<double, 12, 1> h;
  h << std::sqrt(15.0) * x * y, std::sqrt(15.0) * y * z, std::sqrt(5.0) / 2.0 * (3 * z * z - 1),
      std::sqrt(15.0) * x * z, std::sqrt(15.0) / 2.0 * (x * x - y * y),
      std::sqrt(35.0 / 8.0) * y * (3 * x * x - y * y), std::sqrt(105.0) * x * y * z,
      std::sqrt(21.0 / 8.0) * y * (5 * z * z - 1), std::sqrt(7.0) / 2.0 * z * (5 * z * z - 3),
      std::sqrt(21.0 / 8.0) * x * (5 * z * z - 1), std::sqrt(105.0) / 2.0 * z * (x * x - y * y),
      std::sqrt(35.0 / 8.0) * x * (x * x - 3 * y * y);
  return h;
}

}  // namespace

void addScatter(Questions& q) {
  for (RandomBlock& b : shapesOfTheModel(*q.space)) {
    q.scatter.push_back(std::move(b));
    q.scatterNames.emplace_back();
  }
  const ResidualSpace& space = *q.space;
  const Problem& problem = space.problem();
  const auto& features = problem.session().artifact.features;
  if (features.empty() || features.size() > kMostBalls) return;
  const ErrorLayout layout = problem.model().machine().layout();
  const Eigen::MatrixXd& g = problem.slotGradients();
  const int count = static_cast<int>(features.size());
  Eigen::MatrixXd centres = Eigen::MatrixXd::Zero(problem.rowCount(), 3 * count),
                  radii = Eigen::MatrixXd::Zero(problem.rowCount(), count),
                  form = Eigen::MatrixXd::Zero(problem.rowCount(), 12 * count);
  bool balls = false, seen = false;
  for (const int row : space.used()) {
    const Observation& o = problem.session().observations[problem.rows()[row].observation];
    if (o.kind != ObservationKind::kContact) continue;
    const Feature& f = features[o.feature];
    const double unit = q.directionScale.empty() ? 1.0 : space.fitted().sigma[row];
    if (problem.find(UnknownKind::kFeature, o.feature) < 0) {
      seen = true;
      for (int k = 0; k < 3; ++k) centres(row, 3 * o.feature + k) = g(row, layout.feature(k)) * unit;
    }
    if (f.kind != FeatureKind::kBall) continue;
    balls = true;
    radii(row, o.feature) = -unit;
    const Eigen::Vector3d normal(g(row, layout.volume(0)), g(row, layout.volume(1)),
                                 g(row, layout.volume(2)));
    if (normal.norm() > 0.5)
      form.block<1, 12>(row, 12 * o.feature) = unit * harmonics(normal.normalized()).transpose();
  }
  const auto add = [&](const Eigen::MatrixXd& columns, const char* name) {
    q.scatter.push_back({RowMatrix(space.whiten(columns)), 0.0, kPrice, false});
    q.scatterNames.emplace_back(name);
  };
  if (seen && count > 2) add(centres, "centres");
  if (balls && count > 2) add(radii, "radii");
  if (balls) add(form, "form");
}

}  // namespace mm
