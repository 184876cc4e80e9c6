#pragma once
#include <vector>

#include "verification/hypotheses.h"
#include "verification/point_system.h"
#include "verification/verify.h"

namespace mm {

/// The effects that changed since the calibration under one hypothesis, taken one by one.
struct Changes {
  std::vector<ChangedEffect> effects;  // most certain first
  double unexplainedPValue = 1.0;      // of what they leave
  double score = 0.0;                  // of the hypothesis with them: comparable to LoadingEvidence::scores
};

/// How well each hypothesis of what was loaded how fits fresh points: these with unit noise, and what is
/// known of the calibration beforehand.
class LoadingEvidence {
 public:
  /// @param points, system, calibration must outlive it.
  LoadingEvidence(const FreshPoints& points, const PointSystem& system, const Calibration& calibration);

  /// As calibrated, to within its uncertainty and what it left unexplained.
  const Projection& asCalibrated() const { return asCalibrated_; }
  /// Changed since, by as much as machines do.
  Projection changedSince() const;

  /// Log likelihood of each hypothesis, with its prior; the scale of the noise integrated out.
  std::vector<double> scores(const Projection& projection, const std::vector<LoadedHow>& all) const;
  /// Each effect taken costs the logarithm of the number asked and half that of the residuals a parameter
  /// (Schwarz 1978), and its size: a machine seldom changes by more than an error's half.
  Changes changes(const LoadedHow& h) const;

 private:
  Eigen::MatrixXd misses(const std::vector<LoadedHow>& all) const;
  Eigen::MatrixXd scattering(const Eigen::MatrixXd& covariance) const;
  /// As much of each shape as the calibration left unexplained, in units of the noise.
  Eigen::MatrixXd unexplainedShapes() const;
  double freedoms() const { return points_.length() - system_.base().cols(); }
  Eigen::MatrixXd ofEffect(std::size_t e) const;

  const FreshPoints& points_;
  const PointSystem& system_;
  const Calibration& calibration_;
  Eigen::MatrixXd covariance_, byParameter_;
  Projection asCalibrated_;
};

/// What the calibration left of its own session, held out, beyond its noise and its drift, or beyond the
/// noise of these points where that is larger: RMS, m (rad where it has no residuals in m).
double leftUnexplained(const FreshPoints& points, const PointSystem& system, const Calibration& calibration);

/// Which hypothesis the points speak for. @param calibration whose correction it is. @param loaded see
/// VerifyOptions.
Decision decide(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded);

/// The shares that remain, by the axes, by the effects, and across the axes, under the hypothesis's freedom:
/// least squares of the raw readings on the columns. Fills axes, effects and crossed of `found`.
void fillShares(const FreshPoints& points, const PointSystem& system, const Calibration& calibration,
                bool loaded, Verification& found);

/// Covariance of the parameters of the machine's effects, SI.
Eigen::MatrixXd covarianceOf(const FreshPoints& points, const Calibration& calibration);

}  // namespace mm
