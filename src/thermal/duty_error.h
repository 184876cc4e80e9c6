#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

namespace mm {

/// What a line through a few temperatures would leave of the displacement on other duties of the machine,
/// estimated from one series without a second run. Two things make that possible. Heat flow and expansion are
/// linear, so the sums of a run's shifted copies are runs as well, of other duties (Duhamel's superposition);
/// their errors are the same sums of the one run's errors. And all sensors together tell the field of
/// temperature from the sensors' noise: the principal components that are no white noise in time are the
/// field; what they leave is each sensor's noise, which a line passes on by the squares of its slopes. So a
/// set is not taken for the noise of the one run that it happens to fit. Const after construction: of() may
/// be called from several threads.
class DutyError {
 public:
  /// @param temperatures samples x sensors in the order of time, one unit; displacement: samples; finite.
  /// Throws InputError for unequal lengths or fewer than 4 samples.
  DutyError(const Eigen::MatrixXd& temperatures, const Eigen::VectorXd& displacement, std::uint64_t seed);

  /// Root mean square in the unit of the displacement, of the line through the sensors of these indices.
  double of(const std::vector<int>& sensors) const;
  int components() const { return static_cast<int>(loadings_.rows()); }
  double noise(int sensor) const { return std::sqrt(noise_(sensor)); }  ///< unit of the temperatures

 private:
  Eigen::MatrixXd products_;      // of the centred temperatures with each other
  Eigen::VectorXd projections_;   // of the centred temperatures with the displacement
  Eigen::MatrixXd loadings_;      // components x sensors
  Eigen::VectorXd displacement_;  // components
  Eigen::VectorXd noise_;         // variance, a sensor
  Eigen::MatrixXd duties_;        // mean square error of errors given by components
};

}  // namespace mm
