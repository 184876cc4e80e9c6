#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

namespace mm {

// By hand, because both are a few lines over Eigen's decompositions; general minimisers would have to be told
// which of the two centres of a shallow cap is meant.

/// Centre (m) of the sphere through points by linear least squares: |p|^2 = 2 c.p + d.
/// @param scale a length of the size of the sphere, m. @param threshold a cap is too shallow where a pivot of
/// the equations is below this part of the largest. @return none when the points do not determine one.
std::optional<Eigen::Vector3d> algebraicSphereCentre(const std::vector<Eigen::Vector3d>& points, double scale,
                                                     double threshold);

/// Centre (m) of a sphere of known radius (m) through points: algebraic start, then Gauss-Newton on the
/// distances.
/// @param near where to begin instead, where it is known on which side of a shallow cap the centre is: the
/// mirror image fits nearly as well. @return false when it is not determined.
bool sphereCentre(const std::vector<Eigen::Vector3d>& points, double radius, Eigen::Vector3d& centre,
                  const Eigen::Vector3d* near = nullptr);

/// The mean of points, m; at least one.
Eigen::Vector3d meanOf(const std::vector<Eigen::Vector3d>& points);

}  // namespace mm
