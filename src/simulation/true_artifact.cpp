#include "simulation/true_artifact.h"

#include <Eigen/Geometry>
#include <cmath>

#include "base/legendre.h"
#include "base/units.h"

namespace mm {
namespace {

/// Directions evenly over the sphere.
std::vector<Eigen::Vector3d> allRound() {
  constexpr int kCount = 1000;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> directions;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, across = std::sqrt(1.0 - z * z);
    directions.emplace_back(across * std::cos(golden * i), across * std::sin(golden * i), z);
  }
  return directions;
}

}  // namespace

Eigen::Vector3d randomVector(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

double TrueArtifact::Form::at(const Eigen::Vector3d& normal) const {
  double sum = -mean;
  for (const Lobe& lobe : lobes) sum += lobe.height * legendre(lobe.degree, lobe.pole.dot(normal));
  constexpr double kNarrow = 20.0;  // exp(20 (cos - 1)) falls to a half at 15 degrees
  if (spotDepth != 0.0) sum -= spotDepth * std::exp(kNarrow * (spot.dot(normal) - 1.0));
  return sum;
}

TrueArtifact::TrueArtifact(const Artifact& artifact)
    : shift(artifact.features.size(), Eigen::Vector3d::Zero()),
      radiusError(artifact.features.size(), 0.0),
      expansion(artifact.expansion),
      forms_(artifact.features.size()) {
  for (const Feature& feature : artifact.features) {
    positions_.push_back(feature.position);
    radii_.push_back(feature.radius);
  }
}

void TrueArtifact::place(double distance, double turn, Random& random) {
  origin = distance * randomVector(random);
  const Eigen::Vector3d about = randomVector(random);
  orientation = Eigen::AngleAxisd(turn, about.normalized()).toRotationMatrix();
}

void TrueArtifact::turn(double angle, const Eigen::Vector3d& about, const Eigen::Vector3d& by) {
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  origin = rotation * (origin - about) + about + by;
  orientation = rotation * orientation;
  turned_ = rotation * turned_;
}

void TrueArtifact::scatterFree(const Artifact& artifact, double distance, Random& random) {
  for (std::size_t f = 0; f < artifact.features.size(); ++f)
    if (!artifact.features[f].known) positions_[f] += distance * randomVector(random);
}

void TrueArtifact::misshape(double rms, Random& random) {
  const std::vector<Eigen::Vector3d> directions = allRound();
  for (std::size_t f = 0; f < forms_.size(); ++f) {
    shift[f] += rms * randomVector(random);
    radiusError[f] += rms * random.normal();
    Form form;
    for (int degree = 2; degree <= 5; ++degree)
      for (int k = 0; k < 3; ++k)
        form.lobes.push_back({randomVector(random).normalized(), degree, random.normal() / degree});
    form.spot = randomVector(random).normalized();
    form.spotDepth = random.uniform(0.5, 2.0);
    double sum = 0.0, square = 0.0;
    for (const Eigen::Vector3d& direction : directions) {
      const double height = form.at(direction);
      sum += height;
      square += height * height;
    }
    const auto count = static_cast<double>(directions.size());
    form.mean = sum / count;
    const double factor = rms / std::sqrt(square / count - form.mean * form.mean);
    for (Lobe& lobe : form.lobes) lobe.height *= factor;
    form.spotDepth *= factor;
    form.mean *= factor;
    forms_[f] = form;
  }
}

Eigen::Vector3d TrueArtifact::centre(int feature, double artifactTemperature) const {
  const double stretch = 1.0 + expansion * (artifactTemperature - kReferenceTemperature);
  return origin + orientation * ((positions_[feature] + shift[feature]) * stretch);
}

double TrueArtifact::radius(int feature, const Eigen::Vector3d& normal, double artifactTemperature) const {
  const double stretch = 1.0 + expansion * (artifactTemperature - kReferenceTemperature);
  return (radii_[feature] + radiusError[feature]) * stretch +
         forms_[feature].at(turned_.transpose() * normal);
}

}  // namespace mm
