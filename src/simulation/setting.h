#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "simulation/catalogue.h"

namespace mm {

/// Something that an error may depend on, at one instant.
using Quantity = std::function<double(const Condition&)>;

/// Mean and standard deviation of a quantity over the measurements of a session.
struct Spread {
  double mean = 0.0, deviation = 0.0;
};
/// Mean and size of a quantity over the states that are visited.
Spread spreadOf(const Quantity& quantity, const std::vector<Condition>& visits);

/// What the numbers and keys of one source are in one instrument. Immutable.
struct Setting {
  /// @param visits what the session goes through; empty: the source does not ask for it.
  Setting(const HiddenSource& source, const Workshop& workshop, const std::vector<Condition>& visits = {});

  /// What a key of the source names; -1: nothing of that kind.
  struct Named {
    std::string key;
    int joint = -1, body = -1, covariate = -1;
    int component = -1;  // of workpiece: 0, 1, 2 of x, y, z
  };
  const Named& at(const std::string& key) const;  ///< what this key of the source names

  HiddenSource source;
  std::vector<Named> named;          // in the order of the keys
  std::vector<double> lower, upper;  // travel of each joint in the session, m or rad
  std::vector<Eigen::Vector3d> axes,
      linearAxes;                          // of each joint in workpiece; the second zero of a rotary one
  std::vector<double> covariateMeans;      // as stated
  std::vector<Spread> bodies, covariates;  // over the measurements
  double duration = 0.0;                   // s, of the session
};

/// One instant of a source: what its error depends on. SI units, degC. A key of the source says which joint,
/// body or covariate is meant.
struct Instant {
  const Setting& setting;
  const Condition& now;

  double number(const std::string& name) const { return setting.source.number(name); }  ///< as stated, SI
  int joint(const std::string& key = "axis") const { return setting.at(key).joint; }    ///< its number
  double drive(const std::string& key = "axis") const { return now.drive[joint(key)]; }
  double slide(const std::string& key = "axis") const { return now.slide[joint(key)]; }
  double position(const std::string& key) const;  ///< m, from the middle of the session's travel
  double place(const std::string& key) const;     ///< the same over half the travel: -1 to 1
  double velocity(const std::string& key) const;  ///< m/s of the drive; 0 where it is not known
  double side(const std::string& key) const;      ///< -1 to 1: direction of travel, through 0 at standstill
  Eigen::Vector3d tipMotion() const;              ///< m/s, workpiece, by the linear joints
  double slant() const;  ///< 0 for a motion along the vertical stylus, 1 square to it
  double temperature(const std::string& key) const { return now.bodies[setting.at(key).body]; }
  double warmth(const std::string& key) const;    ///< K of a body from its mean over the measurements
  double change(const std::string& key) const;    ///< of a covariate from its stated mean, in its unit
  double moisture(const std::string& key) const;  ///< covariate from its mean, over its standard deviation
  double duration() const { return setting.duration; }       ///< s, of the session
  Eigen::Vector3d unitVector(const std::string& key) const;  ///< of `x`, `y` or `z`
  Direction direction() const;                               ///< of the key `direction`
  Tilt tilt() const;                                         ///< of the keys `about` and `lever`
};

/// What a qualification of the probe on a sphere leaves of an error along the approach: it takes out the
/// radius and the offsets of the stylus that fit best.
Quantity qualified(const Quantity& error, const std::vector<Eigen::Vector3d>& linearAxes,
                   const std::vector<Condition>& visits);

}  // namespace mm
