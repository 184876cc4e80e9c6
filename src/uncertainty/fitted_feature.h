#pragma once
#include <Eigen/Core>
#include <vector>

namespace mm {

/// Associates least-squares (Gaussian) features with measured points near those of a perfect feature: sphere,
/// circle in its own plane, plane, and line across one direction. The linear system depends on the nominal
/// points alone and is solved once; a few steps with the true residuals find the feature itself, as the
/// deviations are small beside it.
class FittedFeature {
 public:
  enum class Kind { kSphere, kCircle, kPlane, kLine };
  /// The feature, relative to the nominal one. Units: m, 1 (tilts).
  struct Found {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // m, displacement (plane, line: along the normal)
    double radius = 0.0;                               // m, of a sphere or circle: found minus nominal
    double form = 0.0;                                 // m, range of the deviations from it
  };

  /// @param normal of circle and plane, unit; of a line, the direction of its deviations. @param nominal
  /// points on the perfect feature, m. @param radius m, of a sphere or circle.
  /// @throw InputError: too few points, or they do not determine the feature.
  FittedFeature(Kind kind, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal, double radius,
                const std::vector<Eigen::Vector3d>& nominal);

  /// @param measured points, m; the first as many as there are nominal ones, from `first` on.
  Found fit(const std::vector<Eigen::Vector3d>& measured, std::size_t first = 0) const;

 private:
  double deviation(const Eigen::Vector3d& measured, const Eigen::VectorXd& feature, std::size_t i) const;

  Kind kind_;
  Eigen::Vector3d centre_, normal_, first_, second_;  // the last two: at right angles to the normal
  double radius_;
  Eigen::MatrixXd design_;   // deviation of a point by a change of the feature
  Eigen::MatrixXd inverse_;  // pseudo-inverse of it
};

}  // namespace mm
