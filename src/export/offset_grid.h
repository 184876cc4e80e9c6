#pragma once
#include <string>
#include <vector>

#include "export/fitted_tables.h"

namespace mm {

/// What joint tables leave to be added to each linear axis, over the positions of all linear axes, and how it
/// changes with each temperature: multilinear between grid points, linear in the temperatures. What
/// LinuxCNC's external offsets can take, as the file of the HAL component `linuxcnc_offsets`.
class OffsetGrid {
 public:
  /// What the position of an axis alone does to it, both directions together, is left to the joint's table,
  /// also what no table can follow.
  explicit OffsetGrid(const NeededCorrection& needed, CorrectionPart part = &NeededCorrection::at);

  /// Added to each linear axis, m, in the order of needed.linear(). Temperatures that are not known count as
  /// the reference ones.
  std::vector<double> at(const State& state) const;
  /// Largest value anywhere at the reference temperatures, and by the whole range of any temperature, m.
  double largest() const { return largest_; }
  /// The file: lengths in mm, temperatures in degC, keys with their units.
  std::string json() const;
  const std::vector<std::string>& letters() const { return letters_; }
  const std::vector<std::string>& sensors() const { return sensors_; }  ///< those that change something

 private:
  double interpolated(const std::vector<double>& values, const State& state) const;

  std::vector<int> joints_;
  std::vector<std::string> letters_, sensors_;
  std::vector<int> sensorOf_;                 // of the domain
  std::vector<double> referenceTemperature_;  // degC, of sensors_
  std::vector<std::vector<double>> at_;       // a joint, m
  std::vector<std::vector<double>> base_;     // an axis: m at each grid point, the last joint fastest
  std::vector<std::vector<std::vector<double>>> perKelvin_;  // a sensor, an axis: m/K
  double largest_ = 0.0;
};

}  // namespace mm
