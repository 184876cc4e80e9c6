#include "report/report_vectors.h"

#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/erase_if.h"
#include "base/units.h"
#include "estimation/residual_vector.h"

namespace mm {
namespace {

constexpr std::size_t kPlaces = 3000;

bool spatial(const std::vector<ResidualVectors::Place>& places) {
  if (places.size() < 3) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : places) mean += p.at / static_cast<double>(places.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const auto& p : places) spread += (p.at - mean) * (p.at - mean).transpose();
  const Eigen::VectorXd sizes = SymmetricEigen(spread).values;
  constexpr double kOnALine = 1e-4;       // squares: a hundredth of the length aside
  return sizes[1] > kOnALine * sizes[2];  // more than a line
}

}  // namespace

ResidualVectors residualVectors(std::vector<NamedFit> fits) {
  ResidualVectors out;
  if (fits.empty()) return out;
  const CalibrationResult& first = *fits.front().fit;
  const Problem& problem = *first.problem;
  eraseIf(fits, [&](const NamedFit& f) { return f.fit->problem->rowCount() != problem.rowCount(); });
  const Session& session = problem.session();
  std::vector<int> used;
  for (std::size_t o = 0; o < session.observations.size(); ++o)
    if (session.observations[o].kind != ObservationKind::kDeviation && problem.uses(static_cast<int>(o)))
      used.push_back(static_cast<int>(o));
  out.observations = static_cast<int>(used.size());
  const std::size_t shown = std::min(kPlaces, used.size());
  out.signedValues = shown > 0;
  for (const NamedFit& f : fits) out.states.push_back({f.name, {}, {}});
  for (std::size_t n = 0; n < shown; ++n) {
    const int observation = used[n * used.size() / shown];
    const Observation& o = session.observations[static_cast<std::size_t>(observation)];
    const State& state = problem.state(observation);
    const int outward = session.outward(o);
    const bool distance = outward != 0, ball = distance && o.kind == ObservationKind::kContact;
    const double reading = std::isfinite(o.laserReading) ? o.laserReading : 0.0;
    const Eigen::Vector3d tip = problem.model().machine().nominal(o.position.data(), reading).position;
    Eigen::Vector3d normal = -state.approach;
    if (state.surfaceNormal.norm() > 0.5) normal = state.surfaceNormal;
    if (distance && !ball)
      normal = (tip - problem.featureInWorkpiece(o.feature, o.placement, first.x)).normalized();
    if (distance && !(normal.norm() > 0.5)) continue;
    ResidualVectors::Place place;
    place.at = tip / kMillimetre;
    if (ball && !std::isfinite(o.laserReading))
      place.at -= normal * session.artifact.tipRadiusOf(o.stylus) / kMillimetre;
    place.row = o.row;
    place.feature = o.feature;
    place.outlier = !(first.weight[problem.firstRow(observation)] > 0.0);
    out.signedValues = out.signedValues && distance;
    out.places.push_back(place);
    for (std::size_t s = 0; s < fits.size(); ++s) {
      const Eigen::Vector3d vector = residualVector(*fits[s].fit, observation, normal) / kMicrometre;
      out.states[s].vectors.push_back(vector);
      out.states[s].values.push_back(distance ? vector.dot(normal) : vector.norm());
    }
  }
  if (!spatial(out.places)) return ResidualVectors();
  for (std::size_t f = 0; f < session.artifact.features.size(); ++f) {
    const Feature& feature = session.artifact.features[f];
    const bool touched = std::any_of(out.places.begin(), out.places.end(),
                                     [&](const auto& p) { return p.feature == static_cast<int>(f); });
    if (feature.kind == FeatureKind::kBall && touched)
      out.balls.push_back({feature.name,
                           problem.featureInWorkpiece(static_cast<int>(f),
                                                      session.placementOf(static_cast<int>(f)), first.x) /
                               kMillimetre,
                           feature.radius / kMillimetre});
  }
  return out;
}

}  // namespace mm
