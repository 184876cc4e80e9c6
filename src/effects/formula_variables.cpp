#include "effects/formula_variables.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/unit_random.h"
#include "base/units.h"

namespace mm {
namespace {

double at(const std::vector<double>& values, std::size_t i, double absent) {
  return i < values.size() ? values[i] : absent;
}

}  // namespace

FormulaVariables::FormulaVariables(const Domain& domain) {
  for (std::size_t j = 0; j < domain.joints.size(); ++j) {
    const Joint& joint = domain.joints[j];
    const double factor = joint.kind == JointKind::kLinear ? 1.0 / kMillimetre : 1.0;
    const double speed = domain.maxSpeed > 0.0 ? domain.maxSpeed : 0.01;
    const int index = static_cast<int>(j);
    define(joint.name, {Kind::kPosition, index, factor, at(domain.lower, j, -0.1), at(domain.upper, j, 0.1),
                        at(domain.lower, j, kNever), at(domain.upper, j, kNever)});
    define(joint.name + "_velocity",
           {Kind::kVelocity, index, factor, -speed, speed, at(domain.velocityLower, j, kNever),
            at(domain.velocityUpper, j, kNever)});
    define(joint.name + "_travel", {Kind::kTravel, index, 1.0, -1.0, 1.0});
  }
  define("t", {Kind::kTime, 0, 1.0, 0.0, std::max(domain.duration, 1.0), 0.0, domain.duration});
  for (std::size_t i = 0; i < domain.sensors.size(); ++i)
    define(domain.sensors[i], {Kind::kTemperature, static_cast<int>(i), 1.0, at(domain.sensorLower, i, 15.0),
                               at(domain.sensorUpper, i, 40.0), at(domain.sensorLower, i, kNever),
                               at(domain.sensorUpper, i, kNever)});
  for (std::size_t i = 0; i < domain.covariates.size(); ++i)
    define(domain.covariates[i],
           {Kind::kCovariate, static_cast<int>(i), 1.0, at(domain.covariateLower, i, -1.0),
            at(domain.covariateUpper, i, 1.0), at(domain.covariateLower, i, kNever),
            at(domain.covariateUpper, i, kNever)});
  constexpr double kHalfRange = 5e-3;  // m, to try a formula with: the range of a short triangulation probe
  if (domain.laser && domain.findCovariate("reading") < 0)
    define("reading", {Kind::kReading, 0, 1.0 / kMillimetre, -kHalfRange, kHalfRange, domain.readingLower,
                       domain.readingUpper});
}

void FormulaVariables::define(const std::string& name, const Variable& variable) {
  std::string usable;
  for (const char c : name) usable += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (usable.empty() || std::isdigit(static_cast<unsigned char>(usable[0])) != 0) usable = "_" + usable;
  names_.push_back(usable);
  variables_.push_back(variable);
}

void FormulaVariables::values(const State& state, const std::vector<int>& indices, double* out) const {
  for (const int i : indices) {
    const Variable& v = variables_[i];
    double value = state.time;
    if (v.kind == Kind::kPosition) value = state.position[v.index];
    if (v.kind == Kind::kVelocity) value = state.velocity[v.index];
    if (v.kind == Kind::kTravel)
      value = state.travel[v.index] == 0.0 ? kNever : std::copysign(1.0, state.travel[v.index]);
    if (v.kind == Kind::kTemperature) value = state.temperature[v.index];
    if (v.kind == Kind::kCovariate) value = state.covariate[v.index];
    if (v.kind == Kind::kReading) value = state.laserReading;
    *out++ = value * v.factor;
  }
}

std::string FormulaVariables::unit(int index) const {
  const Variable& v = variables_[static_cast<std::size_t>(index)];
  const std::string length = v.factor == 1.0 ? "rad" : "mm";
  switch (v.kind) {
    case Kind::kPosition:
    case Kind::kReading:
      return length;
    case Kind::kVelocity:
      return length + "/s";
    case Kind::kTime:
      return "s";
    case Kind::kTemperature:
      return "degC";
    case Kind::kTravel:
    case Kind::kCovariate:
      break;
  }
  return "";
}

bool FormulaVariables::observed(int index, double& lower, double& upper) const {
  const Variable& v = variables_[static_cast<std::size_t>(index)];
  lower = v.observedLower * v.factor;
  upper = v.observedUpper * v.factor;
  constexpr double kRounding = 1e-9;  // of its size: what varies less is constant
  constexpr double kSmall = 1e-3;     // in the formula's units: below it the size counts as this
  return std::isfinite(lower) && std::isfinite(upper) &&
         upper - lower > kRounding * std::max({kSmall, std::abs(lower), std::abs(upper)});
}

double FormulaVariables::sample(int index, std::mt19937_64& random) const {
  const Variable& v = variables_[index];
  if (v.kind == Kind::kTravel) return unitRandom(random) < 0.5 ? -1.0 : 1.0;
  const double range = v.upper - v.lower;
  constexpr double kBeyond = 0.02;      // of the range: a correction is asked somewhat beyond it
  constexpr double kNeverMoved = 1e-3;  // SI: about a value that did not change
  const double margin = range > 0.0 ? kBeyond * range : kNeverMoved;
  return (v.lower - margin + (range + 2.0 * margin) * unitRandom(random)) * v.factor;
}

}  // namespace mm
