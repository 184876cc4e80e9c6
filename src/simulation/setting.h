#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "simulation/catalogue.h"

namespace mm {

/// What the numbers and keys of one source are in one instrument. Immutable.
struct Setting {
  Setting(const HiddenSource& source, const Workshop& workshop);

  /// What a key of the source names; -1: nothing of that kind.
  struct Named {
    std::string key;
    int joint = -1, body = -1, covariate = -1;
    int component = -1;  // of workpiece: 0, 1, 2 of x, y, z
  };
  const Named& at(const std::string& key) const;  ///< what this key of the source names

  HiddenSource source;
  std::vector<Named> named;            // in the order of the keys
  std::vector<double> lower, upper;    // travel of each joint in the session, m or rad
  std::vector<Eigen::Vector3d> axes;   // of each joint in workpiece
  std::vector<double> covariateMeans;  // as stated
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
  double temperature(const std::string& key) const { return now.bodies[setting.at(key).body]; }
  double change(const std::string& key) const;  ///< of a covariate from its stated mean, in its unit
  Eigen::Vector3d unitVector(const std::string& key) const;  ///< of `x`, `y` or `z`
  Direction direction() const;                               ///< of the key `direction`
  Tilt tilt() const;                                         ///< of the keys `about` and `lever`
};

}  // namespace mm
