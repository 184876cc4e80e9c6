#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "simulation/setting.h"

namespace mm {

/// Something that an error may depend on, at one instant.
using Quantity = std::function<double(const Condition&)>;

/// Mean and standard deviation of a quantity over the measurements of a session.
struct Spread {
  double mean = 0.0, deviation = 0.0;
};
/// Mean and size of a quantity over the states that are visited.
Spread spreadOf(const Quantity& quantity, const std::vector<Condition>& visits);

/// A setting that knows what the session goes through. Immutable.
struct VisitedSetting : Setting {
  VisitedSetting(const HiddenSource& source, const Workshop& workshop, const std::vector<Condition>& visits);

  std::vector<Eigen::Vector3d> linearAxes;  // of each joint in workpiece; zero of a rotary one
  std::vector<Spread> bodies, covariates;   // over the measurements
  double duration = 0.0;                    // s, of the session
};

/// One instant of such a setting: what depends on the whole session, too. SI units.
struct VisitedInstant : Instant {
  VisitedInstant(const VisitedSetting& of, const Condition& condition)
      : Instant{of, condition}, session(of) {}
  const VisitedSetting& session;

  double place(const std::string& key) const;     ///< position over half the session's travel: -1 to 1
  double velocity(const std::string& key) const;  ///< m/s of the drive; 0 where it is not known
  double side(const std::string& key) const;      ///< -1 to 1: direction of travel, through 0 at standstill
  Eigen::Vector3d tipMotion() const;              ///< m/s, workpiece, by the linear joints
  double slant() const;                         ///< 0 for a motion along the vertical stylus, 1 square to it
  double warmth(const std::string& key) const;  ///< K of a body from its mean over the measurements
  double moisture(const std::string& key) const;  ///< covariate from its mean, over its standard deviation
  double duration() const { return session.duration; }  ///< s, of the session
};

/// What a qualification of the probe on a sphere leaves of an error along the approach: it takes out the
/// radius and the offsets of the stylus that fit best.
Quantity qualified(const Quantity& error, const std::vector<Eigen::Vector3d>& linearAxes,
                   const std::vector<Condition>& visits);

}  // namespace mm
