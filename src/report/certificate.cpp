#include "report/certificate.h"

#include <cmath>

#include "base/units.h"
#include "compensation/middle_state.h"

namespace mm {
namespace {

constexpr int kCurvePoints = 41;

}  // namespace

std::vector<CorrectionCurve> correctionCurves(const Calibration& calibration) {
  std::vector<CorrectionCurve> curves;
  const Compensator compensator(calibration);
  const Domain& d = compensator.model().domain();
  State middle = middleState(compensator);
  middle.time = d.duration;
  middle.travel.assign(d.joints.size(), 1.0);
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
