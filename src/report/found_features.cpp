#include "report/found_features.h"

namespace mm {

std::vector<FoundFeature> foundFeatures(const CalibrationResult& result) {
  const Problem& problem = *result.problem;
  const auto& features = problem.session().artifact.features;
  std::vector<char> touched(features.size(), 0);
  for (const Observation& o : problem.session().observations)
    if (o.feature >= 0) touched[static_cast<std::size_t>(o.feature)] = 1;
  std::vector<FoundFeature> found;
  for (std::size_t f = 0; f < features.size(); ++f) {
    if (touched[f] == 0) continue;
    const int feature = static_cast<int>(f), placement = problem.session().placementOf(feature);
    const Eigen::Vector3d at = problem.featureInWorkpiece(feature, placement, result.x);
    std::vector<int> of;  // the unknowns that move it
    for (int u = 0; u < problem.unknownCount(); ++u) {
      const Unknown& unknown = problem.unknowns()[static_cast<std::size_t>(u)];
      if (unknown.kind == UnknownKind::kPose ||
          (unknown.kind == UnknownKind::kFeature && unknown.owner == feature))
        of.push_back(u);
    }
    const Eigen::MatrixXd covariance = result.covariance(of, of);
    Eigen::MatrixXd by(3, of.size());
    for (std::size_t i = 0; i < of.size(); ++i) {
      const double h = 1e-6;  // m or rad
      Eigen::VectorXd x = result.x;
      x[of[i]] += h;
      by.col(static_cast<Eigen::Index>(i)) = (problem.featureInWorkpiece(feature, placement, x) - at) / h;
    }
    const Eigen::Matrix3d c = by * covariance * by.transpose();
    const int radius = problem.find(UnknownKind::kRadius, feature);
    found.push_back({features[f].name, features[f].kind == FeatureKind::kBall, at,
                     c.diagonal().cwiseMax(0.0).cwiseSqrt(),
                     features[f].radius + (radius >= 0 ? result.x[radius] : 0.0),
                     radius >= 0 ? result.std(radius) : 0.0});
  }
  return found;
}

}  // namespace mm
