#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "thermal/sensor_selection.h"
#include "tools/sensors_source.h"

namespace mm {

/// Where the sensors sit: sensors x 3, mm. Reads `sensor,x_mm,y_mm,z_mm`; other sensors may be in the file.
/// @throw InputError naming file, line and what is missing.
Eigen::MatrixXd readSensorPositions(const std::string& file, const std::vector<std::string>& sensors);

/// One self-contained SVG: on the left the sensors, coloured by their information, the recommended ones
/// ringed and named (where the positions are known in space, seen at an angle from above; else as bars); on
/// the right information and held-out error against the number of sensors.
std::string sensorsPicture(const SensorSelection& selection, const SensorCandidates& candidates,
                           const std::optional<Eigen::MatrixXd>& positions, const std::string& target);

}  // namespace mm
