#include "compensation/middle_state.h"

namespace mm {

State middleState(const Compensator& compensator) {
  const Domain& d = compensator.model().domain();
  State state = compensator.blankState();
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    state.position[j] = 0.5 * (d.lower[j] + d.upper[j]);
    state.velocity[j] = 0.0;
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    state.temperature[s] = 0.5 * (d.sensorLower[s] + d.sensorUpper[s]);
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    state.covariate[c] = 0.5 * (d.covariateLower[c] + d.covariateUpper[c]);
  if (d.laser) state.laserReading = 0.5 * (d.readingLower + d.readingUpper);
  return state;
}

}  // namespace mm
