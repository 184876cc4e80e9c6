#include "session/free_centres.h"

#include <Eigen/QR>
#include <vector>

namespace mm {
namespace {

/// |p|^2 = 2 c.p + d is linear in the centre c; about the mean of the points, so that nothing cancels.
Eigen::Vector3d ofAnyRadius(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  Eigen::MatrixXd a(points.size(), 4);
  Eigen::VectorXd b(points.size());
  double size = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) size = std::max(size, (points[i] - mean).norm());
  if (points.size() < 4 || size == 0.0) return mean;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p = (points[i] - mean) / size;
    a.row(i) << 2.0 * p.transpose(), 1.0;
    b[i] = p.squaredNorm();
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(a);
  qr.setThreshold(1e-3);  // contacts on a flat patch say too little about the centre
  if (qr.rank() < 4) return mean;
  return mean + size * qr.solve(b).head<3>();
}

}  // namespace

void startFreeFeatures(Session& session) {
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    Feature& feature = session.artifact.features[f];
    if (feature.known || !feature.position.hasNaN()) continue;
    std::vector<Eigen::Vector3d> tips;
    for (const Observation& o : session.observations)
      if (o.kind == ObservationKind::kContact && o.feature == static_cast<int>(f))
        tips.push_back(session.machine.nominal(o.position.data(), o.laserReading).position);
    feature.position.setZero();
    if (tips.empty()) continue;
    if (feature.kind == FeatureKind::kBall) {
      feature.position = ofAnyRadius(tips);
      continue;
    }
    for (const auto& tip : tips) feature.position += tip / static_cast<double>(tips.size());
  }
}

}  // namespace mm
