#include "simulation/true_artifact.h"

#include <Eigen/Geometry>
#include <cmath>

#include "machine/units.h"

namespace mm {
namespace {

Eigen::Vector3d randomVector(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

}  // namespace

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

void TrueArtifact::scatterFree(const Artifact& artifact, double distance, Random& random) {
  for (std::size_t f = 0; f < artifact.features.size(); ++f)
    if (!artifact.features[f].known) positions_[f] += distance * randomVector(random);
}

void TrueArtifact::roughen(double amplitude, Random& random) {
  for (Form& form : forms_) {
    form.wave = randomVector(random).normalized() * random.uniform(2.0, 5.0);
    form.phase = random.uniform(0.0, 2.0 * kPi);
    form.amplitude = amplitude;
  }
}

Eigen::Vector3d TrueArtifact::centre(int feature, double artifactTemperature) const {
  const double stretch = 1.0 + expansion * (artifactTemperature - kReferenceTemperature);
  return origin + orientation * ((positions_[feature] + shift[feature]) * stretch);
}

double TrueArtifact::radius(int feature, const Eigen::Vector3d& normal, double artifactTemperature) const {
  const Form& form = forms_[feature];
  const double stretch = 1.0 + expansion * (artifactTemperature - kReferenceTemperature);
  return (radii_[feature] + radiusError[feature]) * stretch +
         form.amplitude * std::sin(form.wave.dot(normal) + form.phase);
}

}  // namespace mm
