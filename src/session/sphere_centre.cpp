#include "session/sphere_centre.h"

#include <Eigen/Dense>

namespace mm {

bool sphereCentre(const std::vector<Eigen::Vector3d>& points, double radius, Eigen::Vector3d& centre,
                  const Eigen::Vector3d* near) {
  if (points.size() < 4) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::MatrixXd a(points.size(), 4);
  Eigen::VectorXd b(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d d = (points[i] - mean) / radius;
    a.row(static_cast<Eigen::Index>(i)) << d.x(), d.y(), d.z(), 1.0;
    b[static_cast<Eigen::Index>(i)] = 0.5 * d.squaredNorm();
  }
  const Eigen::Vector4d algebraic = a.colPivHouseholderQr().solve(b);
  Eigen::Vector3d c = mean + radius * algebraic.head<3>();
  // a shallow cap lets the algebraic centre slide along its axis: put it at the known distance
  double away = 0.0;
  for (const auto& p : points) away += (p - c).norm();
  away /= static_cast<double>(points.size());
  if (!(away > 0.0) || !c.allFinite()) return false;
  if (away > 3.0 * radius) c = mean + (c - mean).normalized() * radius;
  if (near != nullptr) c = *near;
  for (int iteration = 0; iteration < 50; ++iteration) {
    Eigen::Matrix3d h = Eigen::Matrix3d::Identity() * 1e-12;
    Eigen::Vector3d g = Eigen::Vector3d::Zero();
    for (const auto& p : points) {
      const Eigen::Vector3d d = c - p;
      const Eigen::Vector3d n = d.normalized();
      h += n * n.transpose();
      g += n * (d.norm() - radius);
    }
    Eigen::Vector3d step = h.ldlt().solve(g);
    if (step.norm() > 0.5 * radius) step *= 0.5 * radius / step.norm();
    c -= step;
    if (step.norm() < 1e-10) break;
  }
  centre = c;
  return c.allFinite();
}

}  // namespace mm
