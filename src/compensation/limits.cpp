#include "compensation/limits.h"

#include <cmath>

#include "base/format.h"
#include "base/units.h"
#include "effects/inputs.h"
#include "session/session.h"

namespace mm {
namespace {

constexpr double kReadingSlack = 1e-6;  // m or rad: a joint that stood still may stand there again

}  // namespace

/// "x = 31.2 mm is outside -20 to 20 mm, …", in the unit of people.
std::string CalibratedLimits::Input::outside(double value, const char* remark) const {
  return name + format(" = %.7g%s%s is outside %.7g to %.7g%s%s, the calibrated range with its margin",
                       value * toUnit, unit, remark, lower * toUnit, upper * toUnit, unit, remark);
}

template <typename Answer>
Answer CalibratedLimits::firstOf(const State& state, Answer (*ask)(const Input& input, double value)) const {
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (Answer answer = ask(sensors_[s], state.temperature[s]); answer != Answer()) return answer;
  for (std::size_t c = 0; c < covariates_.size(); ++c)
    if (Answer answer = ask(covariates_[c], state.covariate[c]); answer != Answer()) return answer;
  return {};
}

CalibratedLimits::CalibratedLimits(const Model& model, double margin) {
  const Domain& d = model.domain();
  const auto widened = [margin](const std::string& name, double lower, double upper, double slack) {
    const double wider = margin * (upper - lower) + slack;
    return Input{name, lower - wider, upper + wider};
  };
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    const bool rotary = d.joints[j].kind == JointKind::kRotary;
    readings_.push_back(widened(d.joints[j].name, d.lower[j], d.upper[j], kReadingSlack));
    readings_.back().toUnit = rotary ? 1.0 / kDegree : 1.0 / kMillimetre;
    readings_.back().unit = rotary ? " deg" : " mm";
  }
  for (std::size_t s = 0; s < d.sensors.size(); ++s) {
    sensors_.push_back(widened("temperature " + d.sensors[s], d.sensorLower[s], d.sensorUpper[s], 0.0));
    sensors_.back().unit = " degC";
  }
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    covariates_.push_back(
        widened("covariate " + d.covariates[c], d.covariateLower[c], d.covariateUpper[c], 0.0));
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
  for (std::size_t j = 0; j < readings_.size(); ++j)
    if (!readings_[j].has(state.position[j])) return readings_[j].outside(state.position[j]);
  return {};
}

std::string CalibratedLimits::inputOutside(const State& state) const {
  return firstOf<std::string>(state, [](const Input& input, double value) {
    return input.used && !input.has(value) ? input.outside(value) : std::string();
  });
}

std::string CalibratedLimits::unusual(const State& state) const {
  for (std::size_t s = 0; s < sensors_.size(); ++s)
    if (!sensors_[s].used && !sensors_[s].has(state.temperature[s]))
      return sensors_[s].outside(state.temperature[s], " (the model does not use it)");
  return {};
}

bool CalibratedLimits::lost(const State& state) const {
  return firstOf<bool>(state,
                       [](const Input& input, double value) { return input.used && !std::isfinite(value); });
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
  std::string unknown = firstOf<std::string>(state, [](const Input& input, double value) {
    return input.used && !std::isfinite(value) ? input.name + " is not known" : std::string();
  });
  if (!unknown.empty()) return unknown;
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
