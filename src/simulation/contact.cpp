// Finding the contact: the part of SimulatedMachine where the probe meets the artifact.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "simulation/simulated_machine.h"

namespace mm {
namespace {

constexpr double kShortest = 5e-6;   // m, step of the search: far above what all errors do within it
constexpr double kLookBack = 20e-6;  // m that heat may move a contact while the approach lasts

}  // namespace

double SimulatedMachine::jointRepeatability(std::size_t joint) const {
  return machine_.joints()[joint].kind == JointKind::kLinear ? settings_.noise.repeatability
                                                             : settings_.noise.angularRepeatability;
}

SimulatedMachine::Clearance SimulatedMachine::clearance(const Segment& segment, double part,
                                                        int feature) const {
  std::vector<double> at(segment.from.size());
  for (std::size_t j = 0; j < at.size(); ++j)
    at[j] = segment.from[j] + part * (segment.to[j] - segment.from[j]);
  const double time = time_ + part * segment.duration;
  const Condition now = condition(at, time);
  const ProbePose pose = chain_.pose(now.slide, physics_.distortion(now));
  const double artifactTemperature = now.bodies[physics_.artifactBody];
  Clearance clearance;
  clearance.tip = pose.position + pose.orientation * offset_;
  const Eigen::Vector3d from = clearance.tip - physics_.artifact.centre(feature, artifactTemperature);
  const double distance = from.norm();
  clearance.normal = from / distance;
  clearance.preTravel = physics_.probe.preTravel(-(pose.orientation.transpose() * clearance.normal));
  clearance.left = distance - (physics_.artifact.radius(feature, clearance.normal, artifactTemperature) +
                               artifact_.tipRadiusOf(stylus_) + physics_.probe.radiusError -
                               physics_.probe.wear * time - clearance.preTravel);
  return clearance;
}

std::optional<double> SimulatedMachine::findContact(const Segment& segment, int feature, double from) const {
  // March by the distance that is left (the tip cannot be faster than straight at the ball), then bisect.
  const double length = (chain_.nominal(segment.to).position - chain_.nominal(segment.from).position).norm();
  if (length == 0.0) return std::nullopt;
  double before = from, after = from, left = clearance(segment, from, feature).left;
  if (left <= 0.0) return from;
  while (left > 0.0) {
    if (after >= 1.0) return std::nullopt;
    before = after;
    after = std::min(1.0, after + std::max(0.9 * left, kShortest) / length);
    left = clearance(segment, after, feature).left;
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (before + after);
    (clearance(segment, middle, feature).left > 0.0 ? before : after) = middle;
  }
  return 0.5 * (before + after);
}

Trip SimulatedMachine::latch(const Segment& segment, double part, int feature) {
  Trip trip;
  trip.feature = feature;
  trip.time = time_ + part * segment.duration;
  trip.velocity = segment.velocity;
  trip.travel = travel_;
  const Eigen::Vector3d motion = chain_.nominal(segment.to).position - chain_.nominal(segment.from).position;
  trip.approach = motion.normalized();
  trip.position.resize(segment.from.size());
  const double outlier = noise_.random().uniform(), outlierSize = noise_.random().normal();
  const double wild = noise_.wild() * settings_.noise.repeatability;
  for (std::size_t j = 0; j < trip.position.size(); ++j) {
    const double velocity = segment.velocity[j];
    if (velocity != 0.0) trip.travel[j] = velocity > 0.0 ? 1.0 : -1.0;
    trip.position[j] =
        segment.from[j] + part * (segment.to[j] - segment.from[j]) + velocity * physics_.probe.triggerDelay;
    trip.position[j] += noise_.next(static_cast<int>(j), jointRepeatability(j));
  }
  // An outlier (dirt, vibration) is a trip too early or too late: along the motion.
  const double late =
      wild + (outlier < settings_.noise.outlierShare ? settings_.noise.outlierSize * outlierSize : 0.0);
  if (late != 0.0 && motion.norm() > 0.0)
    for (std::size_t j = 0; j < trip.position.size(); ++j)
      trip.position[j] += (segment.to[j] - segment.from[j]) / motion.norm() * late;
  for (std::size_t j = 0; j < trip.position.size(); ++j)
    trip.position[j] = noise_.read(trip.position[j], jointRepeatability(j));
  const Clearance contact = clearance(segment, part, feature);
  trip.push = -contact.normal;
  trip.truePosition = contact.tip + contact.preTravel * contact.normal;
  return trip;
}

std::optional<Trip> SimulatedMachine::touch(const std::vector<double>& target, double speed, int feature) {
  const double length = (chain_.nominal(target).position - chain_.nominal(drive_).position).norm();
  if (length == 0.0) throw InputError("a touch needs a way to go: target and start are the same place");
  const Segment segment = straightTo(target, length / speed);
  velocity_ = segment.velocity;
  std::optional<double> part = findContact(segment, feature);
  if (part && *part == 0.0)
    throw InputError("the probe touches '" + artifact_.features[feature].name +
                     "' already where the approach begins; begin farther away");
  if (!part) {
    drive(segment, 1.0);
    drive_ = target;
    std::fill(velocity_.begin(), velocity_.end(), 0.0);
    return std::nullopt;
  }
  // Once more with the temperatures of the moment of contact, from where the play was before.
  std::vector<Play> before = play_;
  const double start = time_;
  drive(segment, *part);
  before.swap(play_);
  const double now = time_;
  time_ = start;
  part = findContact(segment, feature, std::max(0.0, *part - kLookBack / length)).value_or(*part);
  Trip trip = latch(segment, *part, feature);
  time_ = now;
  before.swap(play_);
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
  return trip;
}

std::optional<Trip> SimulatedMachine::readLaser(int feature) {
  const double readingNoise =
      noise_.next(machine_.jointCount(), settings_.noise.laser) + noise_.wild() * settings_.noise.laser;
  const bool dropped = noise_.random().uniform() < settings_.noise.laserDropoutShare;
  const bool outlier = noise_.random().uniform() < settings_.noise.outlierShare;
  const double outlierSize = noise_.random().normal() * settings_.noise.outlierSize;
  Trip trip;
  trip.feature = feature;
  trip.time = time_;
  trip.velocity.assign(drive_.size(), 0.0);
  trip.travel = travel_;
  trip.position = drive_;
  for (std::size_t j = 0; j < drive_.size(); ++j) {
    const double size = jointRepeatability(j);
    trip.position[j] = noise_.read(trip.position[j] + noise_.next(static_cast<int>(j), size), size);
  }
  trip.approach = chain_.nominal(drive_).orientation.col(2);

  const Condition now = condition(drive_, time_);
  const Distortion distortion = physics_.distortion(now);
  const ProbePose head = chain_.pose(now.slide, distortion);
  const Eigen::Vector3d beam =
      head.orientation * (Eigen::Vector3d::UnitZ() + distortion.beamTilt).normalized();
  const double artifactTemperature = now.bodies[physics_.artifactBody];
  const Eigen::Vector3d centre = physics_.artifact.centre(feature, artifactTemperature);
  double distance = 0.0;
  Eigen::Vector3d normal = -beam;
  if (artifact_.features[feature].kind == FeatureKind::kPoint) {
    distance = (centre - head.position).dot(beam);  // a target that returns the beam wherever it is hit
  } else {
    for (int i = 0; i < 3; ++i) {  // the form error turns the radius into a function of the place that is hit
      const double radius = physics_.artifact.radius(feature, normal, artifactTemperature);
      const Eigen::Vector3d to = centre - head.position;
      const double along = to.dot(beam), square = radius * radius - (to - along * beam).squaredNorm();
      if (square <= 0.0) return std::nullopt;  // the beam misses the ball
      distance = along - std::sqrt(square);
      normal = (head.position + distance * beam - centre).normalized();
    }
  }
  trip.incidenceCosine = -beam.dot(normal);
  trip.truePosition = head.position + distance * beam;
  trip.laserReading = noise_.read(
      physics_.laser.read(distance, trip.incidenceCosine) + readingNoise + (outlier ? outlierSize : 0.0),
      settings_.noise.laser);
  const bool inRange =
      trip.laserReading >= settings_.laser.rangeLower && trip.laserReading <= settings_.laser.rangeUpper;
  if (dropped || !inRange || trip.incidenceCosine < std::cos(settings_.laser.maxIncidence))
    return std::nullopt;
  return trip;
}

}  // namespace mm
