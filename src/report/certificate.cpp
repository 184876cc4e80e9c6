#include "report/certificate.h"

#include <cmath>

#include "base/units.h"
#include "compensation/compensator.h"

namespace mm {
namespace {

constexpr int kCurvePoints = 41;

}  // namespace

std::vector<CorrectionCurve> correctionCurves(const Calibration& calibration) {
  std::vector<CorrectionCurve> curves;
  const Compensator compensator(calibration);
  const Domain& d = compensator.model().domain();
  State middle = compensator.blankState();
  middle.time = d.duration;
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    middle.position[j] = 0.5 * (d.lower[j] + d.upper[j]);
    middle.velocity[j] = 0.0;
    middle.travel[j] = 1.0;
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    middle.temperature[s] = 0.5 * (d.sensorLower[s] + d.sensorUpper[s]);
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    middle.covariate[c] = 0.5 * (d.covariateLower[c] + d.covariateUpper[c]);
  if (d.laser) middle.laserReading = 0.5 * (d.readingLower + d.readingUpper);
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const double range = d.upper[j] - d.lower[j];
    if (!(range > kStoodStill)) continue;
    const bool rotary = d.joints[j].kind == JointKind::kRotary;
    CorrectionCurve curve;
    curve.axis = d.joints[j].name;
    curve.unit = rotary ? "deg" : "mm";
    bool known = true;
    for (int i = 0; i < kCurvePoints && known; ++i) {
      State state = middle;
      state.position[j] = d.lower[j] + range * i / (kCurvePoints - 1);
      compensator.model().place(state);
      const Correction c = compensator.apply(state);
      known = c.displacement.allFinite() && c.covariance.allFinite();
      curve.at.push_back(state.position[j] / (rotary ? kDegree : kMillimetre));
      curve.correction.emplace_back(c.displacement / kMicrometre);
      curve.expanded.emplace_back(2.0 / kMicrometre * c.covariance.diagonal().cwiseMax(0.0).cwiseSqrt());
    }
    if (known) curves.push_back(std::move(curve));
  }
  return curves;
}

}  // namespace mm
