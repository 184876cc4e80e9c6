#pragma once
#include <vector>

namespace mm {

/// How Klipper fills in heights between the probed points.
enum class MeshAlgorithm { kLagrange, kBicubic, kDirect };

/// A profile of a bed mesh as SAVE_CONFIG writes it; mm.
struct MeshProfile {
  std::vector<std::vector<double>> points;  // heights, row by row of y
  double minX = 0.0, maxX = 0.0, minY = 0.0, maxY = 0.0;
  int betweenX = 0, betweenY = 0;  // mesh_x_pps, mesh_y_pps
  MeshAlgorithm algorithm = MeshAlgorithm::kLagrange;
  double tension = 0.2;
};

/// Klipper's grid of heights (bed_mesh.py, ZMesh): filled in once, straight lines between, the border beyond.
/// mm.
class KlipperMesh {
 public:
  explicit KlipperMesh(const MeshProfile& profile);  ///< points: at least 2 x 2, rows of equal length
  double at(double x, double y) const;               ///< height above the fade target
  std::vector<double> alongX() const;                ///< of the filled grid
  std::vector<double> alongY() const;                ///< of the filled grid
  double average() const { return average_; }  ///< of the filled grid, in hundredths, as Klipper rounds it
  double lowest() const;                       ///< of the grid, less the fade target
  double highest() const;                      ///< of the grid, less the fade target
  void subtract(double height);                ///< the fade target

 private:
  double cell(double coordinate, double lower, double step, int count, int& index) const;
  std::vector<std::vector<double>> grid_;
  double minX_, minY_, stepX_, stepY_, average_ = 0.0;
};

}  // namespace mm
