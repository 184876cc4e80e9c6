#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

/// Centre (m) of a sphere of known radius (m) through points: algebraic start, then Gauss-Newton.
/// @param near where to begin instead, where it is known on which side of a shallow cap the centre is: the
/// mirror image fits nearly as well. @return false when it is not determined.
bool sphereCentre(const std::vector<Eigen::Vector3d>& points, double radius, Eigen::Vector3d& centre,
                  const Eigen::Vector3d* near = nullptr);

}  // namespace mm
