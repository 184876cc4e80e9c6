#pragma once
#include "verification/point_system.h"
#include "verification/verify.h"

namespace mm {

/// Which hypothesis the points speak for, and what none of them explains.
struct Decision {
  LoadedHow hypothesis;
  bool seen = true;  // false: no axis has a correction that these points could show
  bool tablesSeen = true, offsetsSeen = false;  // each of the two
  std::vector<LoadedHow> rivals;                // not excluded, best first
  std::vector<double> odds;                     // of these, against the best
  bool drifted = false;                         // more is wrong than any way of loading explains
  std::vector<ChangedEffect> changed;           // what changed, most certain first
  double unexplainedPValue = 1.0;
};

/// @param calibration whose correction it is. @param loaded see VerifyOptions.
Decision decide(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded);

/// The shares that remain, by the axes, by the effects, and across the axes, under the hypothesis's freedom:
/// least squares of the raw readings on the columns. Fills axes, effects and crossed of `found`.
void fillShares(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded, Verification& found);

/// Covariance of the parameters of the machine's effects, SI.
Eigen::MatrixXd covarianceOf(const FreshPoints& points, const Calibration& calibration);

}  // namespace mm
