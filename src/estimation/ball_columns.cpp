#include "estimation/ball_columns.h"

namespace mm {

BallColumns ballColumns(const Linearisation& at, const std::vector<int>& rows) {
  const Problem& problem = at.problem();
  const auto& features = problem.session().artifact.features;
  if (features.size() < kFewestScattering || features.size() > kMostScattering) return {};
  const ErrorLayout layout = problem.model().machine().layout();
  const Eigen::MatrixXd& g = at.slotGradients();
  const int count = static_cast<int>(features.size());
  BallColumns out{Eigen::MatrixXd::Zero(problem.rowCount(), 3 * count),
                  Eigen::MatrixXd::Zero(problem.rowCount(), count)};
  bool places = false, balls = false;
  for (const int row : rows) {
    const Observation& o = problem.session().observations[problem.rows()[row].observation];
    if (o.kind != ObservationKind::kContact) continue;
    if (problem.find(UnknownKind::kFeature, o.feature) < 0) {
      places = true;
      for (int k = 0; k < 3; ++k) out.centres(row, 3 * o.feature + k) = g(row, layout.feature(k));
    }
    if (features[o.feature].kind == FeatureKind::kBall && problem.find(UnknownKind::kRadius, o.feature) < 0) {
      balls = true;
      out.radii(row, o.feature) = -1.0;
    }
  }
  if (!places) out.centres.resize(0, 0);
  if (!balls) out.radii.resize(0, 0);
  return out;
}

}  // namespace mm
