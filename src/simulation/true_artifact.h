#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "base/random.h"
#include "session/session.h"

namespace mm {

/// Three normal random numbers: no direction is likelier than another.
Eigen::Vector3d randomVector(Random& random);

/// Where and how large the balls really are. Lengths in m.
class TrueArtifact {
 public:
  TrueArtifact() = default;
  /// A perfect artifact that lies where it is said to lie.
  explicit TrueArtifact(const Artifact& artifact);

  /// Lays it down somewhat shifted (m) and turned (rad), at random.
  void place(double shift, double turn, Random& random);
  /// Turned about the vertical through a point of workpiece, then shifted (rad, m), from where it lies now.
  void turn(double angle, const Eigen::Vector3d& about, const Eigen::Vector3d& by);
  /// Moves every feature whose position is not known, at random (m, standard deviation of each component).
  void scatterFree(const Artifact& artifact, double distance, Random& random);
  /// Every ball is lobed and has one worn spot (RMS over its surface: `rms`, m), its radius and its centre
  /// are other than stated (standard deviation of the radius and of each component of the centre: `rms`).
  void misshape(double rms, Random& random);

  Eigen::Vector3d centre(int feature,
                         double artifactTemperature) const;  ///< in workpiece, at a temperature (degC)
  /// Radius (m) at a temperature (degC) seen along the outward normal `normal` (unit vector, workpiece).
  double radius(int feature, const Eigen::Vector3d& normal, double artifactTemperature) const;

  std::vector<Eigen::Vector3d> shift;  // m, a feature: error of its stated position, artifact frame
  std::vector<double> radiusError;     // m, a feature: true less stated
  double expansion = 0.0;              // 1/K, true coefficient
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  // of the artifact's frame in workpiece
  Eigen::Matrix3d orientation = Eigen::Matrix3d::Identity();

 private:
  struct Lobe {
    Eigen::Vector3d pole;
    int degree;  // of the Legendre polynomial of the cosine of the angle from the pole
    double height;
  };
  struct Form {
    std::vector<Lobe> lobes;
    Eigen::Vector3d spot = Eigen::Vector3d::Zero();  // zero: not worn
    double spotDepth = 0.0, mean = 0.0;
    /// m, outwards along a unit vector.
    double at(const Eigen::Vector3d& normal) const;
  };
  Eigen::Matrix3d turned_ = Eigen::Matrix3d::Identity();  // since it was made: its forms turn with it
  std::vector<Eigen::Vector3d> positions_;
  std::vector<double> radii_;
  std::vector<Form> forms_;
};

}  // namespace mm
