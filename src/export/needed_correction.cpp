#include "export/needed_correction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/covariance_root.h"
#include "base/error.h"
#include "base/nearest_name.h"
#include "compensation/compensator.h"
#include "machine/linear_inverse.h"

namespace mm {
namespace {

constexpr double kNoTravel = 1e-5;  // m or rad: an axis that has no more has no table

constexpr int kMostSteps = 20;
constexpr int kReadingSteps = 3;  // each leaves a ten thousandth of the one before
constexpr int kChangeStates = 64;
constexpr unsigned kChangeSeed = 71;
constexpr double kLeastChange = 1e-8;     // m, between any two states
constexpr double kNeededReached = 1e-12;  // m

/// One column of a Latin hypercube: the middles of `count` equal parts of a range, in random order.
std::vector<double> latin(int count, double lower, double upper, std::mt19937_64& random) {
  std::vector<double> column(count);
  for (int i = 0; i < count; ++i) column[i] = lower + (i + 0.5) / count * (upper - lower);
  for (std::size_t i = column.size() - 1; i > 0; --i) std::swap(column[i], column[random() % (i + 1)]);
  return column;
}

}  // namespace

NeededCorrection::NeededCorrection(const Calibration& calibration,
                                   const std::map<std::string, std::string>& letters)
    : model_(Machine(calibration.urdf, calibration.machineName), calibration.domain, calibration.effects,
             calibration.networks) {
  const Compensator checks(calibration);  // throws where the file contradicts itself
  parameters_.resize(calibration.values.size());
  for (Eigen::Index p = 0; p < parameters_.size(); ++p) parameters_[p] = calibration.values[p].value;
  covariance_ = calibration.covariance;
  linear_ = linearJoints(model_.machine().joints());
  axes_ = exportAxes(model_.machine(), letters, calibration.domain.lower, calibration.domain.upper);
  compensation_ = calibration.compensation;
  active_ = loadedCompensation(compensation_);
  if (active_) activePoints_ = active_->points();
  checkActive();
  Eigen::MatrixXd samples(axes_.size(), kChangeStates);
  int n = 0;
  for (const State& state : states(kChangeStates, kChangeSeed)) samples.col(n++) = adds(state);
  changes_ = (samples.rowwise().maxCoeff() - samples.rowwise().minCoeff()).array() > kLeastChange;
}

void NeededCorrection::checkActive() const {
  std::vector<std::string> here;
  for (const ExportAxis& axis : axes_) here.push_back(axis.letter);
  for (const auto& [letter, at] : activePoints_)
    if (findAxis(letter) == nullptr)
      throw InputError("the compensation that was active while measuring (" + compensation_.inWords() +
                       ") is for axis " + letter + ", and the machine's axes are " + listOf(here) +
                       "; assign its joint with --axis JOINT=" + letter);
}

const ExportAxis* NeededCorrection::findAxis(const std::string& letter) const {
  for (const ExportAxis& axis : axes_)
    if (axis.letter == letter) return &axis;
  return nullptr;
}

std::vector<double> NeededCorrection::activePoints(int joint) const {
  const auto found = activePoints_.find(axes_[joint].letter);
  return found == activePoints_.end() ? std::vector<double>{} : found->second;
}

std::pair<double, double> NeededCorrection::tabulated(int joint) const {
  const ExportAxis& axis = axes_[joint];
  const std::vector<double> points = activePoints(joint);
  if (points.empty()) return {axis.lower, axis.upper};
  return {std::min(axis.lower, points.front()), std::max(axis.upper, points.back())};
}

bool NeededCorrection::moved(int joint) const {
  const ExportAxis& axis = axes_[joint];
  return axis.upper - axis.lower > kNoTravel;
}

double NeededCorrection::reference(int joint) const {
  const ExportAxis& axis = axes_[joint];
  return std::clamp(0.0, axis.lower, axis.upper);
}

std::vector<State> NeededCorrection::states(int count, unsigned seed) const {
  const Domain& d = model_.domain();
  std::mt19937_64 random(seed);
  std::vector<State> all(count);
  for (State& state : all) {
    state.velocity.assign(d.joints.size(), 0.0);
    state.laserReading = d.laser ? 0.0 : std::numeric_limits<double>::quiet_NaN();
  }
  const auto fill = [&](double lower, double upper, auto put) {
    const std::vector<double> values = latin(count, lower, upper, random);
    for (std::size_t i = 0; i < all.size(); ++i) put(all[i], values[i]);
  };
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    fill(d.lower[j], d.upper[j], [](State& s, double v) { s.position.push_back(v); });
    fill(-1.0, 1.0, [](State& s, double v) { s.travel.push_back(v < 0.0 ? -1.0 : 1.0); });
  }
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    fill(d.sensorLower[k], d.sensorUpper[k], [](State& s, double v) { s.temperature.push_back(v); });
  for (std::size_t k = 0; k < d.covariates.size(); ++k)
    fill(d.covariateLower[k], d.covariateUpper[k], [](State& s, double v) { s.covariate.push_back(v); });
  fill(0.0, std::max(0.0, d.duration), [](State& s, double v) { s.time = v; });
  if (d.laser) fill(d.readingLower, d.readingUpper, [](State& s, double v) { s.laserReading = v; });
  return all;
}

Eigen::Vector3d NeededCorrection::truePosition(State state,
                                               Eigen::Matrix<double, 6, Eigen::Dynamic>* byParameter) const {
  const SettledTemperatures history(state.temperature);
  state.history = &history;
  model_.place(state);
  Model::Workspace work;
  return model_.corrected(state, parameters_.data(), work, byParameter).position;
}

Eigen::Vector3d NeededCorrection::besideNominal(const State& command, std::vector<double> readings) const {
  const double beam = model_.domain().laser ? command.laserReading : std::numeric_limits<double>::quiet_NaN();
  State driven = command;
  driven.position = std::move(readings);
  return truePosition(std::move(driven)) - model_.machine().nominal(command.position.data(), beam).position;
}

Eigen::Vector3d NeededCorrection::displacement(const State& state) const {
  return besideNominal(state, state.position);
}

Eigen::MatrixXd NeededCorrection::uncertain(const std::vector<State>& states) const {
  const Eigen::MatrixXd root = rootOfCovariance(covariance_);
  Eigen::MatrixXd changes(3 * states.size(), root.cols());
  Eigen::Matrix<double, 6, Eigen::Dynamic> byParameter(6, parameters_.size());
  for (std::size_t n = 0; n < states.size(); ++n) {
    truePosition(states[n], &byParameter);
    changes.middleRows<3>(3 * n) = byParameter.topRows<3>() * root;
  }
  return changes;
}

Eigen::Vector3d NeededCorrection::missed(const State& command, const std::vector<double>& motors) const {
  if (!active_) return besideNominal(command, motors);
  // The reading at which the motors stood there while it was measured: reading + active(reading) = motors.
  State reading = command;
  reading.position = motors;
  for (int step = 0; step < kReadingSteps; ++step) {
    const Eigen::VectorXd added = activeAt(reading);
    for (std::size_t j = 0; j < motors.size(); ++j) reading.position[j] = motors[j] - added[j];
  }
  return besideNominal(command, reading.position);
}

Eigen::VectorXd NeededCorrection::activeAt(const State& command) const {
  Eigen::VectorXd added = Eigen::VectorXd::Zero(axes_.size());
  if (!active_) return added;
  const std::map<std::string, double> found = active_->adds(commandOf(command));
  for (const ExportAxis& axis : axes_) added[axis.joint] = found.at(axis.letter);
  return added;
}

Eigen::VectorXd NeededCorrection::adds(const State& given) const {
  State command = given;
  if (active_)  // whose tables may reach beyond what the session observed
    for (const ExportAxis& axis : axes_) {
      double& position = command.position[axis.joint];
      position = std::clamp(position, axis.lower, axis.upper);
    }
  const double beam = model_.domain().laser ? command.laserReading : std::numeric_limits<double>::quiet_NaN();
  std::vector<double> readings = command.position;
  for (int step = 0; step < kMostSteps; ++step) {
    const Eigen::Vector3d miss = besideNominal(command, readings);
    if (!miss.allFinite())
      throw NumericalError(
          "the calibration has no finite correction inside its own range: an input of its effects was never "
          "recorded; calibrate with it, or remove the effect");
    const LinearMotion motion = linearMotion(model_.machine(), readings.data(), beam, -miss);
    for (std::size_t j = 0; j < readings.size(); ++j) readings[j] += motion.change[j];
    if (motion.change.cwiseAbs().maxCoeff() < kNeededReached) break;
  }
  Eigen::VectorXd delta(readings.size());
  for (std::size_t j = 0; j < readings.size(); ++j) delta[j] = readings[j] - command.position[j];
  return delta;
}

Eigen::VectorXd NeededCorrection::at(const State& command) const {
  const Eigen::VectorXd added = adds(command);
  if (!active_) return added;
  State reading = command;
  for (std::size_t j = 0; j < reading.position.size(); ++j) reading.position[j] += added[j];
  return added + activeAt(reading);
}

CommandedState NeededCorrection::commandOf(const State& state) const {
  CommandedState command;
  for (const ExportAxis& axis : axes_) {
    const int j = axis.joint;
    command.position[axis.letter] = state.position[j];
    command.direction[axis.letter] = state.travel[j] > 0.0 ? 1 : state.travel[j] < 0.0 ? -1 : 0;
  }
  const Domain& d = model_.domain();
  for (std::size_t k = 0; k < d.sensors.size(); ++k)
    if (std::isfinite(state.temperature[k])) command.temperature[d.sensors[k]] = state.temperature[k];
  return command;
}

}  // namespace mm
