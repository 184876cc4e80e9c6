#pragma once
#include <functional>
#include <string>
#include <vector>

#include "simulation/catalogue.h"

namespace mm {

/// Something that an error may depend on, at one instant.
using Quantity = std::function<double(const Condition&)>;

/// The quantities of one instrument from which an uncatalogued source is shaped: the keys of the source say
/// which joints, bodies and covariates they are taken from.
class Setting {
 public:
  /// @throw InputError where a key names nothing that this instrument has, or nothing is measured.
  Setting(const HiddenSource& source, const Workshop& workshop);

  Quantity position(const std::string& key) const;  ///< m, from the middle of the session's travel
  Quantity place(const std::string& key) const;     ///< the same over half the travel: -1 to 1
  Quantity velocity(const std::string& key) const;  ///< m/s of the drive
  Quantity side(const std::string& key) const;      ///< -1 to 1: direction of travel, through 0 at standstill
  Quantity tipSpeed() const;                        ///< m/s
  Quantity slant() const;  ///< 0 for a motion along the vertical stylus, 1 square to it
  Quantity warmth(const std::string& key) const;    ///< K of a body from its mean over the measurements
  Quantity moisture(const std::string& key) const;  ///< covariate from its mean, over its standard deviation
  /// What a qualification of the probe on a sphere leaves of an error along the approach: it takes out the
  /// radius and the offsets of the stylus that fit best.
  Quantity qualified(const Quantity& error) const;
  double number(const std::string& name) const { return source_.number(name); }
  double duration() const { return duration_; }  ///< s, of the session

 private:
  int joint(const std::string& key) const;

  const HiddenSource& source_;
  const Workshop& workshop_;
  const std::vector<Condition>& visits_;
  double duration_ = 0.0;
};

/// Motion of the tip (m/s, workpiece) by the linear joints whose axes are given; zero at standstill.
Eigen::Vector3d tipMotion(const std::vector<Eigen::Vector3d>& axes, const Condition& condition);
/// Axis of each joint in workpiece; zero for a rotary one.
std::vector<Eigen::Vector3d> linearAxes(const Workshop& workshop);
/// Mean and standard deviation of a quantity over the measurements of a session.
struct Spread {
  double mean = 0.0, deviation = 0.0;
};
/// Mean and size of a quantity over the states that are visited.
Spread spreadOf(const Quantity& quantity, const std::vector<Condition>& visits);

}  // namespace mm
