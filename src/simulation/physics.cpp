#include "simulation/physics.h"

#include <cmath>

#include "base/units.h"

namespace mm {

double TrueCovariate::at(double time) const {
  if (time < from || time >= to) return 0.0;
  const double turn = 2.0 * kPi * time / period + phase;
  return mean + swing * (std::sin(turn) + 0.3 * std::sin(2.7 * turn + 1.0));
}

Distortion Physics::distortion(const Condition& condition) const {
  Distortion sum(static_cast<int>(condition.drive.size()));
  for (const Source& source : sources) source(condition, sum);
  return sum;
}

Condition Truth::condition(const TrueState& state) const {
  const std::size_t joints = state.position.size();
  const bool laser = !std::isnan(state.laserReading);
  Condition now;
  now.time = state.time;
  now.velocity = state.velocity;
  now.travel = state.travel;
  now.drive = state.position;
  now.slide.resize(joints);
  for (std::size_t j = 0; j < joints; ++j) {
    if (!laser && !std::isnan(state.velocity[j]))
      now.drive[j] -= state.velocity[j] * physics_.probe.triggerDelay;
    now.slide[j] = now.drive[j] - 0.5 * physics_.gap[j] * state.travel[j];
  }
  now.bodies = thermal_.recorded(state.time);
  for (const TrueCovariate& covariate : physics_.covariates)
    now.covariates.push_back(covariate.at(state.time));
  return now;
}

ProbePose Truth::pose(const TrueState& state) const {
  const bool laser = !std::isnan(state.laserReading);
  const Condition now = condition(state);
  const Distortion distortion = physics_.distortion(now);
  ProbePose pose = chain_.pose(now.slide, distortion);
  if (laser) {
    const Eigen::Vector3d beam = (Eigen::Vector3d::UnitZ() + distortion.beamTilt).normalized();
    pose.position +=
        pose.orientation * beam * physics_.laser.distanceOf(state.laserReading, state.incidenceCosine);
  } else if (!state.approach.isZero(0.0)) {
    const Eigen::Vector3d& push = state.push.isZero(0.0) ? state.approach : state.push;
    pose.position -= physics_.probe.preTravel(pose.orientation.transpose() * push) * push;
  }
  return pose;
}

Eigen::Vector3d Truth::nominal(const TrueState& state) const {
  ProbePose pose = chain_.nominal(state.position);
  if (!std::isnan(state.laserReading)) pose.position += pose.orientation.col(2) * state.laserReading;
  return pose.position;
}

Eigen::Vector3d Truth::featureCentre(int feature, double time) const {
  return physics_.artifact.centre(feature, temperature(physics_.artifactBody, time));
}

}  // namespace mm
