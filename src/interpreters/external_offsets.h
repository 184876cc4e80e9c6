#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "interpreters/interpreter.h"

namespace mm {

/// What the HAL component `linuxcnc_offsets` adds to LinuxCNC's linear axes beside their tables, by its
/// rules: multilinear between grid points, beyond the grid its edge, linear in the temperatures, a
/// thermometer that tells no number as if it stood at the reference of the file (docs/export.md).
class ExternalOffsets {
 public:
  static constexpr const char* kFile = "external_offsets.json";  ///< its name in the folder of an export

  /// @param file external_offsets.json, version 1. @throw InputError: not readable, or what the component
  /// would refuse.
  explicit ExternalOffsets(const std::filesystem::path& file);

  const std::vector<std::string>& letters() const { return letters_; }  ///< axes that it moves
  JointPoints points() const;                                           ///< of its grid
  /// Added to each of these axes, m. @throw InputError: `command` lacks the position of an axis.
  std::map<std::string, double> at(const CommandedState& command) const;

 private:
  struct Sensor {
    std::string name;
    double reference = 0.0;                      // degC
    std::vector<std::vector<double>> perKelvin;  // an axis, a grid point: m/K
  };

  std::vector<std::string> letters_;
  std::vector<std::vector<double>> positions_;  // an axis: ascending, m
  std::vector<std::vector<double>> base_;       // an axis, a grid point (the last axis fastest): m
  std::vector<Sensor> sensors_;
};

}  // namespace mm
