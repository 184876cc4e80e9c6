#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace mm::test {

/// One contact as a row of the import format, in mm.
struct PlateRow {
  double time = 0.0;
  Eigen::Vector3d position, velocity;  // mm, mm/s
  std::string feature;
  double bed = 20.0;  // degC
};

/// Nine balls of 3.9685 mm at three heights, so that no mirror image of the plate is the plate.
inline std::vector<Eigen::Vector3d> plateCentres() {
  return {{-13, -8, -9}, {0, -8, -2},   {13, -8, 5}, {-13, 10, 5}, {0, 10, -9},
          {13, 10, -2},  {-13, 28, -2}, {0, 28, 5},  {13, 28, -9}};
}

inline std::string plateArtifact() {
  std::string yaml = "name: plate\npose: free\nprobe: {tip_radius_mm: 1.0, repeatability_um: 0.3}\nballs:\n";
  const auto centres = plateCentres();
  for (std::size_t b = 0; b < centres.size(); ++b)
    yaml += "  - {name: b" + std::to_string(b) + ", centre_mm: [" + std::to_string(centres[b].x()) + ", " +
            std::to_string(centres[b].y()) + ", " + std::to_string(centres[b].z()) +
            "], radius_mm: 3.9685}\n";
  return yaml;
}

/// Touches square to the balls, the balls in turn, 75 each, noise of 0.3 um. The machine's x scale is long by
/// 50 um/m and has a play of `gap` (mm).
inline std::vector<PlateRow> plateRows(double gap = 0.0, int perBall = 75) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.5e-3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<PlateRow> rows;
  const auto centres = plateCentres();
  for (int k = 0; k < perBall; ++k)
    for (std::size_t b = 0; b < centres.size(); ++b) {
      const double z = 1.0 - 1.25 * (k + 0.5) / perBall, s = std::sqrt(1.0 - z * z);
      const double azimuth = 2.39996 * k + 0.7 * static_cast<double>(b);
      const Eigen::Vector3d n(s * std::cos(azimuth), s * std::sin(azimuth), z);
      PlateRow row;
      row.time = 8.0 * static_cast<double>(rows.size());
      row.velocity = -2.0 * n;
      row.position =
          turn * centres[b] + Eigen::Vector3d(0.05, -0.03, 0.02) + (4.9685 + 3e-4 * normal(generator)) * n;
      row.position.x() += -50e-6 * row.position.x() + 0.5 * gap * (row.velocity.x() > 0.0 ? 1.0 : -1.0);
      row.feature = "b" + std::to_string(b);
      row.bed = 20.5 + 2.0 * std::sin(row.time / 900.0);
      rows.push_back(row);
    }
  return rows;
}

inline std::string plateCsv(const std::vector<PlateRow>& rows, bool velocities) {
  std::string csv = "time_s,x_mm,y_mm,z_mm,feature,bed_degC";
  csv += velocities ? ",x_velocity_mm_s,y_velocity_mm_s,z_velocity_mm_s\n" : "\n";
  char line[240];
  for (const PlateRow& r : rows) {
    std::snprintf(line, sizeof line, "%.3f,%.6f,%.6f,%.6f,%s,%.3f", r.time, r.position.x(), r.position.y(),
                  r.position.z(), r.feature.c_str(), r.bed);
    csv += line;
    if (velocities) {
      std::snprintf(line, sizeof line, ",%.5f,%.5f,%.5f", r.velocity.x(), r.velocity.y(), r.velocity.z());
      csv += line;
    }
    csv += "\n";
  }
  return csv;
}

}  // namespace mm::test
