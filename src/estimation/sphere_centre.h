#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

/// Centre (m) of a sphere of known radius (m) through points: algebraic start, then Gauss-Newton.
/// @return false when it is not determined.
bool sphereCentre(const std::vector<Eigen::Vector3d>& points, double radius, Eigen::Vector3d& centre);

}  // namespace mm
