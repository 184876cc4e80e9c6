#include "estimation/residual_vector.h"

namespace mm {

Eigen::Vector3d residualVector(const CalibrationResult& fit, int observation, const Eigen::Vector3d& normal) {
  const Problem& problem = *fit.problem;
  const Session& session = problem.session();
  const Observation& o = session.observations[static_cast<std::size_t>(observation)];
  const int first = problem.firstRow(observation), last = problem.firstRow(observation + 1);
  const int outward = session.outward(o);
  if (outward != 0) return outward * normal * fit.residuals[first];
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();
  for (int row = first; row < last; ++row) {
    const ResidualRow& r = problem.rows()[static_cast<std::size_t>(row)];
    if (r.angular) continue;
    if (o.kind == ObservationKind::kDeviation)
      vector -=
          fit.residuals[row] * session.machine.seenAsDeviation(r.component, o.position.data(), o.laserReading)
                                   .head<3>()
                                   .transpose();
    else
      vector[r.component] = fit.residuals[row];
  }
  if (o.kind == ObservationKind::kPosition) return -(problem.artifactRotation(o.placement, fit.x) * vector);
  return vector;
}

}  // namespace mm
