#include "compensation/limits.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "base/units.h"
#include "effects/inputs.h"
#include "session/session.h"

namespace mm {
namespace {

constexpr double kReadingSlack = 1e-6;  // m or rad: a joint that stood still may stand there again

/// "x = 31.2 mm is outside -20 ... 20 mm", in the unit of people.
std::string outside(const std::string& name, double value, double lower, double upper, double toUnit,
                    const char* unit) {
  char text[160];
  std::snprintf(text, sizeof text,
                " = %.7g%s is outside %.7g to %.7g%s, the calibrated range with its margin", value * toUnit,
                unit, lower * toUnit, upper * toUnit, unit);
  return name + text;
}

}  // namespace

CalibratedLimits::CalibratedLimits(const Model& model, double margin) {
  const Domain& d = model.domain();
  joints_ = d.joints;
  const auto widened = [margin](const std::string& name, double lower, double upper, double slack) {
    const double wider = margin * (upper - lower) + slack;
    return Input{name, lower - wider, upper + wider, false};
  };
  for (std::size_t j = 0; j < d.joints.size(); ++j)
    readings_.push_back(widened(d.joints[j].name, d.lower[j], d.upper[j], kReadingSlack));
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    sensors_.push_back(widened(d.sensors[s], d.sensorLower[s], d.sensorUpper[s], 0.0));
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    covariates_.push_back(widened(d.covariates[c], d.covariateLower[c], d.covariateUpper[c], 0.0));
  findUsed(model);
}

void CalibratedLimits::findUsed(const Model& model) {
  const Domain& d = model.domain();
  usesTravel_.assign(d.joints.size(), false);
  usesVelocity_.assign(d.joints.size(), false);
  for (const EffectPtr& effect : model.effects()) {
    const Inputs inputs = inputsOf(*effect, d);
    // What acts on a touch alone says nothing of where the probe is; of a touch its direction must be known.
    usesApproach_ = usesApproach_ || inputs.approach;
    if (inputs.approach || effect->nature().stage == Stage::kArtifact) continue;
    for (const int s : inputs.temperatures) sensors_[static_cast<std::size_t>(s)].used = true;
    for (const int c : inputs.covariates) covariates_[static_cast<std::size_t>(c)].used = true;
    for (const int j : inputs.travels) usesTravel_[static_cast<std::size_t>(j)] = true;
    for (const int j : inputs.velocities)  // a joint that never moved stands still
      if (d.upper[j] - d.lower[j] > kStoodStill) usesVelocity_[static_cast<std::size_t>(j)] = true;
    usesTime_ = usesTime_ || inputs.time;
    usesHistory_ = usesHistory_ || inputs.history;
  }
}

std::string CalibratedLimits::jointOutside(const State& state) const {
  for (std::size_t j = 0; j < readings_.size(); ++j) {
    const Input& r = readings_[j];
    const bool rotary = joints_[j].kind == JointKind::kRotary;
    if (state.position[j] < r.lower || state.position[j] > r.upper)
      return outside(r.name, state.position[j], r.lower, r.upper, rotary ? 1.0 / kDegree : 1.0 / kMillimetre,
                     rotary ? " deg" : " mm");
  }
  return {};
}

std::string CalibratedLimits::inputOutside(const State& state) const {
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (sensors_[s].used &&
        (state.temperature[s] < sensors_[s].lower || state.temperature[s] > sensors_[s].upper))
      return outside("temperature " + sensors_[s].name, state.temperature[s], sensors_[s].lower,
                     sensors_[s].upper, 1.0, " degC");
  for (std::size_t c = 0; c < covariates_.size(); ++c)
    if (covariates_[c].used &&
        (state.covariate[c] < covariates_[c].lower || state.covariate[c] > covariates_[c].upper))
      return outside("covariate " + covariates_[c].name, state.covariate[c], covariates_[c].lower,
                     covariates_[c].upper, 1.0, "");
  return {};
}

std::string CalibratedLimits::unusual(const State& state) const {
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (!sensors_[s].used &&
        (state.temperature[s] < sensors_[s].lower || state.temperature[s] > sensors_[s].upper))
      return outside("temperature " + sensors_[s].name, state.temperature[s], sensors_[s].lower,
                     sensors_[s].upper, 1.0, " degC (the model does not use it)");
  return {};
}

bool CalibratedLimits::lost(const State& state) const {
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (sensors_[s].used && !std::isfinite(state.temperature[s])) return true;
  for (std::size_t c = 0; c < covariates_.size(); ++c)
    if (covariates_[c].used && !std::isfinite(state.covariate[c])) return true;
  return false;
}

/// The joints of which the model needs the direction of travel, but nobody knows it, and what to do.
std::string CalibratedLimits::withoutTravel(const State& state) const {
  std::string names;
  bool silent = false;  // without a velocity no motion will ever tell
  for (std::size_t j = 0; j < readings_.size(); ++j) {
    if (!usesTravel_[j] || std::abs(state.travel[j]) > 0.0) continue;
    names += (names.empty() ? "" : ", ") + readings_[j].name;
    silent |= !std::isfinite(state.velocity[j]);
  }
  if (names.empty()) return {};
  return "direction of travel of " + names + " is not known (the model has an error that depends on it); " +
         (silent ? "its velocity must be given with its reading"
                 : "move " + names + ", in either direction, by more than its backlash");
}

std::string CalibratedLimits::missing(const State& state) const {
  for (std::size_t j = 0; j < readings_.size(); ++j)
    if (!std::isfinite(state.position[j])) return "reading of joint " + readings_[j].name + " is not known";
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (sensors_[s].used && !std::isfinite(state.temperature[s]))
      return "temperature " + sensors_[s].name + " is not known";
  for (std::size_t c = 0; c < covariates_.size(); ++c)
    if (covariates_[c].used && !std::isfinite(state.covariate[c]))
      return "covariate " + covariates_[c].name + " is not known";
  if (const std::string unmoved = withoutTravel(state); !unmoved.empty()) return unmoved;
  for (std::size_t j = 0; j < readings_.size(); ++j)
    if (usesVelocity_[j] && !std::isfinite(state.velocity[j]))
      return "velocity of " + readings_[j].name + " is not known";
  if (usesTime_ && !std::isfinite(state.time)) return "time is not known";
  if (usesApproach_ && state.feature >= 0 && !(state.approach.squaredNorm() > 0.0))
    return "direction of approach is not known";
  if (usesHistory_ && state.history == nullptr) return "history of the temperatures is not known";
  return {};
}

}  // namespace mm
