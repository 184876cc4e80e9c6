// What a VirtualMachine takes from the calibration before the first draw.
#include <algorithm>
#include <cmath>

#include "base/covariance_root.h"
#include "base/dense.h"
#include "base/error.h"
#include "base/format.h"
#include "base/names_of.h"
#include "base/nearest_name.h"
#include "base/units.h"
#include "effects/effect_words.h"
#include "uncertainty/virtual_machine.h"

namespace mm {
namespace {

constexpr double kAcross = 1e-6;  // of a normal: an axis at right angles to it does not approach
constexpr double kPositive =
    1e-10;  // added to a correlation matrix, that rounding leaves it positive definite

constexpr double kNearlyNormalFrom = 200.0;  // degrees of freedom from which Student's t is drawn as normal
constexpr double kSeenOfDrift = 1.0 / 3.0;   // of the variance along a direction, by contacts all around
constexpr double kSmoothShare = 0.5;         // of the remainder's variance, where its size alone is known
constexpr double kFewestPlaces = 4.0;        // fewer leave Student's t without a variance to speak of
constexpr double kTemperatureStep = 1e-3;    // K, of a derivative where no uncertainty is stated

Compensator::Options optionsOf(const TaskConditions& conditions) {
  Compensator::Options options;
  options.margin = conditions.margin;
  options.sigma = false;
  return options;
}

int jointNamed(const std::string& name, const Domain& domain, const char* option) {
  const int j = domain.findJoint(name);
  const std::vector<std::string> names = allNames(domain.joints);
  if (j < 0)
    throw InputError(std::string(option) + ": '" + name + "' is not an axis of this machine" +
                     didYouMean(name, names) + "; it has " + listOf(names));
  return j;
}

std::string placeInWords(const Eigen::Vector3d& at) {
  return format("at (%.6g, %.6g, %.6g) mm", at.x() / kMillimetre, at.y() / kMillimetre, at.z() / kMillimetre);
}

Eigen::Vector3d motionAlong(const std::string& direction, const Model& model, const State& state) {
  const double beam = model.domain().laser ? state.laserReading : kNotMeasured;
  return motionAlong(direction, model.domain(), model.machine().jacobian(state.position.data(), beam));
}

}  // namespace

VirtualMachine::VirtualMachine(const Calibration& calibration, const MeasurementTask& task,
                               const TaskConditions& conditions)
    : compensator_(calibration, optionsOf(conditions)), interval_(conditions.interval) {
  place(calibration, task, conditions);
  addParameters(calibration);
  addDrift(calibration);
  addRemainder(calibration, conditions);
  if (conditions.artifactScale > 0.0) {
    const Domain& d = compensator_.model().domain();
    const Eigen::Vector3d middle = 0.5 * (d.tipLower + d.tipUpper);
    const auto fromMiddle = [&](const Point& point) { return Eigen::Vector3d(point.place - middle); };
    add("scale of the artifact", {Cause::kCommon, conditions.artifactScale, byPoint(fromMiddle)});
  }
  const auto normal = [](const Point& point) { return point.normal; };
  if (conditions.artifactRadius > 0.0)
    add("radius of the reference ball", {Cause::kCommon, conditions.artifactRadius, byPoint(normal)});
  addTemperatures(conditions);
}

State VirtualMachine::blank(const TaskConditions& conditions) {
  const Domain& d = compensator_.model().domain();
  State state = middleState(compensator_);
  state.time = std::isnan(conditions.time) ? d.duration : conditions.time;
  for (const TaskConditions::Temperature& t : conditions.temperatures) {
    const int s = d.findSensor(t.sensor);
    if (s < 0)
      throw InputError("--temperature: '" + t.sensor + "' is not a sensor of this calibration" +
                       didYouMean(t.sensor, d.sensors) + "; it has " + listOf(d.sensors));
    state.temperature[s] = t.value;
  }
  temperature_ = state.temperature;
  history_ = std::make_unique<SettledTemperatures>(temperature_);
  state.history = history_.get();
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    if (d.joints[j].kind == JointKind::kRotary && d.lower[j] <= 0.0 && d.upper[j] >= 0.0)
      state.position[j] = 0.0;
    state.travel[j] = 1.0;
  }
  for (const auto& p : conditions.positions) state.position[jointNamed(p.joint, d, "--joint")] = p.value;
  for (const auto& t : conditions.travel) state.travel[jointNamed(t.joint, d, "--direction")] = t.value;
  return state;
}

void VirtualMachine::place(const Calibration& calibration, const MeasurementTask& task,
                           const TaskConditions& conditions) {
  const Model& model = compensator_.model();
  const Domain& d = model.domain();
  const State start = blank(conditions);
  values_.resize(calibration.values.size());
  for (Eigen::Index k = 0; k < values_.size(); ++k) values_[k] = calibration.values[k].value;
  Model::Workspace work;
  Eigen::Matrix<double, 6, Eigen::Dynamic> byParameter;
  const int distance = model.machine().layout().distance();
  for (const TaskPoint& p : task.points) {
    Point point;
    point.state = start;
    point.place = p.place;
    point.normal = p.normal;
    State& state = point.state;
    if (point.normal.isZero(0.0)) point.normal = -conditions.approach;
    std::vector<double> arrival = start.travel;
    const double beam = d.laser ? state.laserReading : kNotMeasured;
    if (!point.normal.isZero(0.0)) {
      if (!d.laser) state.approach = -point.normal;
      state.surfaceNormal = point.normal;
      const Eigen::Matrix3Xd jacobian = model.machine().jacobian(state.position.data(), beam).topRows<3>();
      for (std::size_t j = 0; j < arrival.size(); ++j) {
        if (d.joints[j].kind != JointKind::kLinear) continue;
        const double part = -jacobian.col(j).dot(point.normal);
        if (std::abs(part) > kAcross) arrival[j] = part > 0.0 ? 1.0 : -1.0;
        state.velocity[j] = d.laser ? 0.0 : conditions.contactSpeed * part;
      }
    }
    if (p.axis >= 0) arrival[p.axis] = p.side;
    state.travel = arrival;
    model.place(state);
    const TargetReadings target = compensator_.correctTarget(p.place, state, arrival);
    const Correction& c = target.correction;
    if (!c.corrected.position.allFinite())
      throw InputError(placeInWords(p.place) + ": " + (target.reason.empty() ? c.reason : target.reason));
    if (!target.reached && outside_.size() < 3) {
      const std::string why = placeInWords(p.place) + ": " + target.reason;
      if (std::find(outside_.begin(), outside_.end(), why) == outside_.end()) outside_.push_back(why);
    }
    if (!c.note.empty() && std::find(notes_.begin(), notes_.end(), c.note) == notes_.end() &&
        notes_.size() < 5)
      notes_.push_back(c.note);
    state.position = target.position;
    model.place(state);
    model.corrected(state, values_.data(), work, &byParameter);
    point.byParameter = byParameter.topRows<3>();
    for (const Model::Derivative& derivative : work.derivatives)
      if (derivative.slot == distance)
        point.byParameter.col(derivative.parameter) -= derivative.value * point.normal;
    point.calibrated = seen(point, values_.data(), work);
    points_.push_back(std::move(point));
  }
}

void VirtualMachine::addParameters(const Calibration& calibration) {
  const Model& model = compensator_.model();
  const Eigen::Index n = values_.size();
  sourceOf_.assign(n, -1);
  root_ = Eigen::MatrixXd::Zero(n, n);
  if (n == 0) return;
  const Eigen::MatrixXd& covariance = calibration.covariance;
  Eigen::VectorXd std = covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  for (Eigen::Index k = 0; k < n; ++k)
    if (!std::isfinite(std[k]) || !covariance.row(k).allFinite())
      throw InputError(
          "parameter '" + calibration.values[k].name +
          "' has no finite standard uncertainty: the session did not determine it; remove its effect or "
          "calibrate with a session that determines it (mm check)");
  // Each independent variable of the root stays with the parameter that it resembles most, so that shares are
  // those of CAR scores (Zuber & Strimmer 2011).
  root_ = rootOfCovariance(covariance);
  for (std::size_t e = 0; e < model.effects().size(); ++e) {
    bool varies = false;
    for (int k = 0; k < model.effects()[e]->parameterCount(); ++k) {
      const int p = model.offset(e) + k;
      if (!(std[p] > 0.0)) continue;
      sourceOf_[p] = sources_.size();
      varies = true;
    }
    if (!varies) continue;
    linear_ = linear_ && model.effects()[e]->linear();
    add(inWords(model.effects()[e]->spec()), {Cause::kParameters});
  }
  if (calibration.degreesOfFreedom > 0.0 && calibration.degreesOfFreedom <= 2.0)
    throw InputError(
        format("calibration '%s' has %.3g degrees of freedom: the distribution of its parameters "
               "has no variance; calibrate with more contacts",
               calibration.id.c_str(), calibration.degreesOfFreedom));
  if (calibration.degreesOfFreedom > 0.0 && calibration.degreesOfFreedom < kNearlyNormalFrom)
    freedoms_ = calibration.degreesOfFreedom;
}

void VirtualMachine::addDrift(const Calibration& calibration) {
  for (const Wandering& w : calibration.drift) {
    const auto along = [&](const Point& point) {
      return motionAlong(w.direction, compensator_.model(), point.state);
    };
    if (w.std > 0.0)
      add("drift of " + w.direction, {Cause::kDrift, w.std, byPoint(along), w.timeConstant, w.smooth});
  }
}

void VirtualMachine::addRemainder(const Calibration& c, const TaskConditions& conditions) {
  const Domain& d = compensator_.model().domain();
  const bool told = std::isfinite(c.rms);
  double probe = conditions.repeatability >= 0.0 ? conditions.repeatability : (told ? c.repeatability : 0.0);
  if (!told)
    notes_.push_back(
        "the calibration has no residuals in um, so probe and unexplained error are unknown; state "
        "--repeatability-um");
  else if (c.repeatabilityFrom == "estimated" && conditions.repeatability < 0.0)
    notes_.push_back(
        "the repeatability was estimated from the residuals and includes what the model does not explain");
  if (probe > 0.0) add("repeatability of the probe", {Cause::kProbe, probe});
  if (!told) return;
  const double length =
      std::isnan(conditions.remainderLength) ? usualRemainderLength(d) : conditions.remainderLength;
  remainder_ = conditions.remainder ? *conditions.remainder : remainderBySize(c, length);
  if (remainder_.places > 0.0) remainder_.places = std::max(kFewestPlaces, remainder_.places);
  const double size = std::sqrt((remainder_.smooth.squaredNorm() + remainder_.rough.squaredNorm()) / 3.0);
  if (!(size > 0.0)) return;
  add("unexplained remainder", {Cause::kRemainder, size});
  const Eigen::Index n = points_.size();
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Identity(n, n) * (1.0 + kPositive);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < i; ++j) {
      const double apart = (points_[i].place - points_[j].place).squaredNorm();
      correlation(i, j) = correlation(j, i) =
          remainder_.length > 0.0 ? std::exp(-0.5 * apart / (remainder_.length * remainder_.length)) : 0.0;
    }
  smooth_ = Cholesky(correlation).lower();
}

double usualRemainderLength(const Domain& domain) {
  return 0.25 * (domain.tipUpper - domain.tipLower).norm();
}

/// What the residuals at places that the fit did not use have beyond repeatability and drift: in which
/// direction, and over which lengths, their size alone does not tell.
Remainder VirtualMachine::remainderBySize(const Calibration& c, double length) const {
  const bool contacts = !compensator_.model().domain().features.empty();
  double left = std::isfinite(c.heldOutRms) ? c.heldOutRms * c.heldOutRms : c.rms * c.rms;
  left -= c.repeatability * c.repeatability;
  for (const Wandering& w : c.drift) {
    const Eigen::Vector3d along = motionAlong(w.direction, compensator_.model(), points_.front().state);
    left -= (contacts ? kSeenOfDrift : 1.0) * w.std * w.std * along.squaredNorm();
  }
  Remainder found;
  if (left > 0.0) {
    found.smooth.setConstant(std::sqrt(kSmoothShare * left));
    found.rough.setConstant(std::sqrt((1.0 - kSmoothShare) * left));
  }
  found.length = length;
  return found;
}

void VirtualMachine::addTemperatures(const TaskConditions& conditions) {
  const Model& model = compensator_.model();
  Model::Workspace work;
  for (const TaskConditions::Temperature& t : conditions.temperatures) {
    if (!(t.std > 0.0)) continue;
    const int s = model.domain().findSensor(t.sensor);
    const double step = std::max(t.std, kTemperatureStep), was = temperature_[s];
    const auto perKelvin = [&](Point point) {
      Eigen::Vector3d sides[2];
      for (const int side : {0, 1}) {
        temperature_[s] = point.state.temperature[s] = was + (side == 0 ? -step : step);
        sides[side] = seen(point, values_.data(), work);
      }
      temperature_[s] = was;
      return Eigen::Vector3d((sides[1] - sides[0]) / (2.0 * step));
    };
    Source source{Cause::kCommon, t.std, byPoint(perKelvin)};
    if (!source.along.isZero(0.0)) add("temperature " + t.sensor, std::move(source));
  }
}

}  // namespace mm
