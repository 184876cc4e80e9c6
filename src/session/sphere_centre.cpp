#include "session/sphere_centre.h"

#include <Eigen/Geometry>

#include "base/dense.h"

namespace mm {
namespace {

constexpr int kMostIterations = 50;
constexpr double kSettled = 1e-10;  // m: far below any probe, above the rounding of a machine of metres
constexpr double kRidge = 1e-12;    // of one contact's weight: a direction that no contact sees stays
constexpr double kFarOff = 3.0;  // radii: an algebraic centre farther from its points has slid along the cap
constexpr double kLongestStep = 0.5;  // radii: beyond it the distances are no longer nearly linear
constexpr double kAnySphere = 0.0;    // Gauss-Newton mends what a shallow cap leaves open

}  // namespace

Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p;
  return mean / static_cast<double>(points.size());
}

std::optional<Eigen::Vector3d> algebraicSphereCentre(const std::vector<Eigen::Vector3d>& points, double scale,
                                                     double threshold) {
  if (points.size() < 4 || !(scale > 0.0)) return std::nullopt;
  const Eigen::Vector3d mean = meanOf(points);  // about it, so that nothing cancels
  Eigen::MatrixXd a(points.size(), 4);
  Eigen::VectorXd b(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d d = (points[i] - mean) / scale;
    a.row(static_cast<Eigen::Index>(i)) << 2.0 * d.transpose(), 1.0;
    b[static_cast<Eigen::Index>(i)] = d.squaredNorm();
  }
  if (threshold > 0.0 && rankOf(a, threshold) < 4) return std::nullopt;
  const Eigen::Vector3d centre = mean + scale * leastSquares(a, b).head<3>();
  if (!centre.allFinite()) return std::nullopt;
  return centre;
}

bool sphereCentre(const std::vector<Eigen::Vector3d>& points, double radius, Eigen::Vector3d& centre,
                  const Eigen::Vector3d* near) {
  const std::optional<Eigen::Vector3d> algebraic = algebraicSphereCentre(points, radius, kAnySphere);
  if (!algebraic) return false;
  Eigen::Vector3d c = *algebraic;
  // a shallow cap lets the algebraic centre slide along its axis: put it at the known distance
  double away = 0.0;
  for (const auto& p : points) away += (p - c).norm();
  away /= static_cast<double>(points.size());
  if (!(away > 0.0)) return false;
  const Eigen::Vector3d mean = meanOf(points);
  if (away > kFarOff * radius) c = mean + (c - mean).normalized() * radius;
  if (near != nullptr) c = *near;
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Identity() * kRidge;
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const auto& p : points) {
      const Eigen::Vector3d d = c - p;
      const Eigen::Vector3d n = d.normalized();
      h += n * n.transpose();
      g += n * (d.norm() - radius);
    }
    Eigen::Vector3d step = solveSymmetric(h, g);
    if (step.norm() > kLongestStep * radius) step *= kLongestStep * radius / step.norm();
    c -= step;
    if (step.norm() < kSettled) break;
  }
  centre = c;
  return c.allFinite();
}

}  // namespace mm
