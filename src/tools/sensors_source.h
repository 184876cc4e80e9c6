#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace mm {

/// Temperatures of all candidate sensors and the displacement that they shall explain, sampled together in
/// the order of time.
struct SensorCandidates {
  std::vector<std::string> names;
  Eigen::MatrixXd temperatures;  // samples x sensors, degC
  Eigen::VectorXd displacement;
  double micrometres = 1.0;  // um (arcsec for a rotary axis) of one unit of the displacement

  /// Of a candidate, as the series names its column.
  const std::string& name(int sensor) const { return names[static_cast<std::size_t>(sensor)]; }
  /// Several sensors, "a + b".
  std::string namesOf(const std::vector<int>& sensors, const std::string& between = " + ") const;
};

/// From a CSV (mm sensors), or from a session's bag: there the target is an axis, or deviation_<axis>_um.
/// What the machine is off along the axis is gathered in sets, as a network learns it; of several positions,
/// the course that varies most. From what a
/// CalculiX run printed (`.dat`): the target is the mean displacement of a node set, `NOSE_x_m`.
/// @param space of `--namespace`, for a bag. @throw InputError naming file, column or axis.
SensorCandidates readSensorCandidates(const std::string& file, const std::string& target,
                                      const std::string& space = {});

}  // namespace mm
