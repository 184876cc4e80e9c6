#pragma once
#include <Eigen/Core>
#include <limits>
#include <vector>

namespace mm {

/// Temperatures as they were: what an effect with a memory (a lag) asks. Sensor indices are those of the
/// Domain.
class TemperatureHistory {
 public:
  virtual ~TemperatureHistory() = default;
  /// Response at `time` (s) of a first-order lag with time constant `tau` (s) to the sensor's temperature
  /// (degC), settled at the first value; and its derivative with respect to tau.
  virtual double lagged(int sensor, double tau, double time, double* byTau) const = 0;
};

/// Temperatures that have been what they are for ever.
class SettledTemperatures final : public TemperatureHistory {
 public:
  /// @param temperature of each sensor, degC; it must live as long.
  explicit SettledTemperatures(const std::vector<double>& temperature) : temperature_(temperature) {}
  double lagged(int sensor, double, double, double* byTau) const override {
    if (byTau != nullptr) *byTau = 0.0;
    return temperature_[sensor];
  }

 private:
  const std::vector<double>& temperature_;
};

/// The inputs of the effects at one moment: uncorrected readings and what else was logged. SI units, degC.
struct State {
  double time = 0.0;  // s from the session's start (live: from the last homing)
  /// Which of the sessions of the Domain it belongs to, from 0; what is measured after them is like the last.
  int recording = std::numeric_limits<int>::max();
  int stylus = 0;                // index of the Domain
  std::vector<double> position;  // a joint
  std::vector<double> velocity;  // a joint; NaN: not known
  std::vector<double> travel;    // a joint; -1, +1, 0: not known
  /// A joint; m or rad that it has travelled since its last reversal, at the least. NaN: not known; empty or
  /// infinite: taken as far away.
  std::vector<double> sinceReversal;
  std::vector<double> temperature;  // a sensor of the Domain; NaN: not known
  std::vector<double> covariate;    // a covariate of the Domain; NaN: not known
  /// Unit vector in workpiece towards the surface. Zero or NaN with a feature: not known (effects of the
  /// contact give NaN); without a feature: nothing is touched (they give nothing).
  Eigen::Vector3d approach = Eigen::Vector3d::Zero();
  /// Outward unit normal of the touched surface, in workpiece; zero or NaN: not known.
  Eigen::Vector3d surfaceNormal = Eigen::Vector3d::Zero();
  double laserReading = 0.0;                                  // m
  int feature = -1;                                           // touched feature, index of the Domain
  Eigen::Vector3d featurePosition = Eigen::Vector3d::Zero();  // its nominal position in the artifact, m
  double featureRadius = 0.0;                                 // m, of a ball
  Eigen::Vector3d tip =
      Eigen::Vector3d::Zero();  // nominal origin of probe_tip (no beam) in workpiece: the lever, m
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();  // nominal, of probe_tip in workpiece
  const TemperatureHistory* history = nullptr;

  /// m or rad; infinity where nothing is told of the joint.
  double sinceReversalOf(int joint) const {
    const auto j = static_cast<std::size_t>(joint);
    return j < sinceReversal.size() ? sinceReversal[j] : std::numeric_limits<double>::infinity();
  }
};

}  // namespace mm
