#include "simulation/simulated_machine.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/dense.h"
#include "base/error.h"

namespace mm {
namespace {

// of rough temperature sensors: K, K (standard deviation), K of the readings, s
constexpr double kSensorNoise = 0.05, kSensorOffset = 0.2, kSensorStep = 0.0625;
constexpr double kSensorLagLower = 30.0, kSensorLagUpper = 300.0;

/// Speed at which the motors are as busy as they can be, as a share of the joint's highest velocity.
double activityOf(const Machine& machine, const std::vector<double>& velocity) {
  double busy = 0.0;
  for (int j = 0; j < machine.jointCount(); ++j) {
    const double highest = machine.joints()[j].maxVelocity;
    if (highest > 0.0) busy = std::max(busy, std::min(1.0, std::abs(velocity[j]) / highest));
  }
  return busy > 0.0 ? std::sqrt(busy) : 0.0;  // current rises slower than speed: friction dominates
}

}  // namespace

SimulatedMachine::SimulatedMachine(Machine machine, Artifact artifact, InstrumentSettings settings,
                                   Physics physics, std::uint64_t seed)
    : machine_(std::move(machine)),
      artifact_(std::move(artifact)),
      settings_(std::move(settings)),
      physics_(std::move(physics)),
      chain_(machine_),
      thermal_(settings_.thermalModel()),
      drive_(machine_.joints().size(), 0.0),
      velocity_(drive_.size(), 0.0),
      travel_(drive_.size(), 0.0),
      noise_(settings_.noise, settings_.rough, seed, 2 * machine_.jointCount() + 4),
      sensorNoise_(seed, "sensors") {
  for (const double gap : physics_.gap) play_.emplace_back(gap);
  thermal_.addFollowers(physics_.followers);
  for (const std::string& name : settings_.thermal.sensors) {
    const int body = thermal_.findBody(name);
    const Roughness& rough = settings_.rough;
    Random making(seed, "rough sensor " + name);
    const double lag = making.logUniform(kSensorLagLower, kSensorLagUpper);
    if (rough.sensors > 0.0)
      sensors_.emplace_back(body, lag, rough.sensors * kSensorNoise,
                            rough.sensors * kSensorOffset * making.normal(), rough.sensors * kSensorStep);
    else
      sensors_.emplace_back(body, settings_.thermal.sensorLag, settings_.noise.temperature);
    sensors_.back().settle(thermal_.temperatures()[body]);
    temperatureLog_.push_back({name, "degC", {}, {}});
  }
  for (const TrueCovariate& covariate : physics_.covariates)
    covariateLog_.push_back({covariate.name, covariate.unit, {}, {}});
  log();
}

void SimulatedMachine::loadCorrection(ControllerAdds correction) {
  correction_ = std::move(correction);
  home(drive_);
}

std::vector<double> SimulatedMachine::corrected(const std::vector<double>& command) const {
  if (!correction_) return command;
  std::map<std::string, double> temperatures;
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    temperatures[settings_.thermal.sensors[s]] = sensors_[s].value();
  std::vector<double> drives = correction_(command, travelNow(), temperatures);
  for (std::size_t j = 0; j < drives.size(); ++j) drives[j] += command[j];
  return drives;
}

std::vector<double> SimulatedMachine::travelNow() const {
  std::vector<double> travel = travel_;
  for (std::size_t j = 0; j < travel.size(); ++j)
    if (velocity_[j] != 0.0) travel[j] = velocity_[j] > 0.0 ? 1.0 : -1.0;
  return travel;
}

void SimulatedMachine::home(const std::vector<double>& readings) {
  drive_ = readings;
  const std::vector<double> driven = corrected(drive_);
  for (std::size_t j = 0; j < drive_.size(); ++j) play_[j].centre(driven[j]);
}

Condition SimulatedMachine::condition(const std::vector<double>& drive, double time) const {
  Condition now;
  now.time = time;
  now.drive = corrected(drive);
  now.velocity = velocity_;
  now.travel = travelNow();
  now.slide.resize(drive.size());
  for (std::size_t j = 0; j < drive.size(); ++j) now.slide[j] = play_[j].after(now.drive[j]);
  now.bodies = thermal_.temperatures();
  for (const TrueCovariate& covariate : physics_.covariates) now.covariates.push_back(covariate.at(time));
  return now;
}

Eigen::Vector3d SimulatedMachine::trueTip() const {
  const Condition now = condition(drive_, time_);
  return chain_.pose(now.slide, physics_.distortion(now)).position;
}

void SimulatedMachine::log() {
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    temperatureLog_[s].time.push_back(time_);
    temperatureLog_[s].value.push_back(sensors_[s].read(sensorNoise_));
  }
  for (std::size_t c = 0; c < covariateLog_.size(); ++c) {
    covariateLog_[c].time.push_back(time_);
    covariateLog_[c].value.push_back(physics_.covariates[c].at(time_));
  }
  nextLog_ += settings_.thermal.logPeriod;
}

void SimulatedMachine::pass(double seconds, double activity) {
  const double end = time_ + seconds;
  while (time_ < end) {
    constexpr double kTick = 1e-9;  // s: time goes on when a record is due just now
    const double dt = std::min(end, std::max(nextLog_, time_ + kTick)) - time_;
    if (dt <= 0.0) break;
    thermal_.advance(dt, activity);
    for (TemperatureSensor& sensor : sensors_) sensor.advance(dt, thermal_.temperatures()[sensor.body()]);
    time_ += dt;
    if (time_ >= nextLog_) log();
  }
}

std::vector<double> SimulatedMachine::temperatures() {
  std::vector<double> values;
  for (const TemperatureSensor& sensor : sensors_) values.push_back(sensor.read(sensorNoise_));
  return values;
}

void SimulatedMachine::wait(double seconds) {
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
  pass(seconds, 0.0);
}

SimulatedMachine::Segment SimulatedMachine::straightTo(const std::vector<double>& target,
                                                       double duration) const {
  Segment segment{drive_, target, target, duration};
  for (std::size_t j = 0; j < drive_.size(); ++j) segment.velocity[j] = (target[j] - drive_[j]) / duration;
  return segment;
}

void SimulatedMachine::drive(const Segment& segment, double part) {
  velocity_ = segment.velocity;
  travel_ = travelNow();
  for (std::size_t j = 0; j < drive_.size(); ++j)
    drive_[j] = segment.from[j] + part * (segment.to[j] - segment.from[j]);
  const std::vector<double> driven = corrected(drive_);
  for (std::size_t j = 0; j < drive_.size(); ++j) play_[j].follow(driven[j]);
  pass(part * segment.duration, activityOf(machine_, velocity_));
}

void SimulatedMachine::moveTo(const std::vector<double>& target, double linear, double rotary) {
  double duration = 0.0;
  for (std::size_t j = 0; j < drive_.size(); ++j) {
    const double highest = machine_.joints()[j].kind == JointKind::kLinear ? linear : rotary;
    duration = std::max(duration, std::abs(target[j] - drive_[j]) / highest);
  }
  if (duration == 0.0) return;
  drive(straightTo(target, duration), 1.0);
  drive_ = target;
  std::fill(velocity_.begin(), velocity_.end(), 0.0);
}

void SimulatedMachine::step(const std::vector<double>& target, const std::vector<double>& speed,
                            double seconds) {
  if (seconds <= 0.0) return;
  std::vector<double> to = drive_;
  for (std::size_t j = 0; j < drive_.size(); ++j) {
    const double reach = speed[j] * seconds;
    to[j] += std::clamp(target[j] - drive_[j], -reach, reach);
  }
  const Segment segment = straightTo(to, seconds);
  bool touchesNow = false;
  if (!settings_.laser.present)
    for (int f = 0; f < static_cast<int>(artifact_.features.size()); ++f) {
      if (artifact_.features[f].kind != FeatureKind::kBall) continue;
      const bool before = clearance(segment, 0.0, f).left <= 0.0,
                 after = clearance(segment, 1.0, f).left <= 0.0;
      touchesNow = touchesNow || after;
      if (before || !after || touching_ || trip_) continue;
      if (const std::optional<double> part = findContact(segment, f)) trip_ = latch(segment, *part, f);
    }
  touching_ = touchesNow;
  drive(segment, 1.0);
}

std::optional<Trip> SimulatedMachine::readLaser() {
  std::optional<Trip> nearest;
  for (int f = 0; f < static_cast<int>(artifact_.features.size()); ++f) {
    const std::optional<Trip> trip = readLaser(f);
    if (trip && (!nearest || trip->laserReading < nearest->laserReading)) nearest = trip;
  }
  return nearest;
}

/// A star, or a tracker's target: the readings at which the perfect machine would look where this one does.
/// The line of sight is square to both axes when the readings are zero.
double SimulatedMachine::sightDeviation(int joint, const ProbePose& truth) const {
  const std::vector<double> zero(2, 0.0);
  const Eigen::Matrix3d home = chain_.nominal(zero).orientation;
  const Eigen::Vector3d ahead = home.transpose() * chain_.axis(0).cross(chain_.axis(1)).normalized();
  const Eigen::Vector3d wanted = truth.orientation * ahead;
  std::vector<double> q = drive_;
  for (int step = 0; step < 4; ++step) {
    const Eigen::Vector3d now = chain_.nominal(q).orientation * ahead;
    Eigen::MatrixXd moves(3, 2);
    for (int j = 0; j < 2; ++j) {
      constexpr double kStep = 1e-4;
      std::vector<double> moved = q;
      moved[j] += kStep;
      moves.col(j) = (chain_.nominal(moved).orientation * ahead - now) / kStep;
    }
    const Eigen::Vector2d change = leastSquares(moves, wanted - now);
    for (int j = 0; j < 2; ++j) q[j] += change[j];
  }
  return q[joint] - drive_[joint];
}

double SimulatedMachine::measureDeviation(int joint) {
  const Condition now = condition(drive_, time_);
  const Distortion distortion = physics_.distortion(now);
  const ProbePose truth = chain_.pose(now.slide, distortion), said = chain_.nominal(drive_);
  std::vector<double> ahead = drive_;
  constexpr double kStep = 1e-3;
  ahead[joint] += kStep;
  const ProbePose next = chain_.nominal(ahead);
  const bool linear = chain_.kind(joint) == JointKind::kLinear;
  const double size = linear ? settings_.noise.reference : settings_.noise.referenceAngular;
  const double error = noise_.next(machine_.jointCount() + 1 + joint, size) + noise_.wild() * size;
  if (linear)
    return noise_.read((truth.position - said.position).dot((next.position - said.position) / kStep) + error,
                       size);
  if (chain_.jointCount() == 2 && chain_.kind(1 - joint) != JointKind::kLinear)
    return noise_.read(sightDeviation(joint, truth) + error, size);
  // A polygon on the axis and an autocollimator: rotation of the probe against its nominal about the joint's
  // axis.
  const Eigen::Matrix3d turned = truth.orientation * said.orientation.transpose();
  const Eigen::Matrix3d unit = next.orientation * said.orientation.transpose();
  const auto vector = [](const Eigen::Matrix3d& r) {
    return Eigen::Vector3d(0.5 * (r(2, 1) - r(1, 2)), 0.5 * (r(0, 2) - r(2, 0)), 0.5 * (r(1, 0) - r(0, 1)));
  };
  return noise_.read(vector(turned).dot(vector(unit).normalized()) + error, size);
}

Eigen::Vector3d SimulatedMachine::measurePosition() {
  Eigen::Vector3d position = trueTip();
  const double size = settings_.noise.reference, wild = noise_.wild();
  for (int k = 0; k < 3; ++k)
    position(k) = noise_.read(
        position(k) + noise_.next(2 * machine_.jointCount() + 1 + k, size) + (k == 0 ? wild * size : 0.0),
        size);
  return position;
}

}  // namespace mm
