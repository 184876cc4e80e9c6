#include "ros_bridge/plugin_terms.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.h"
#include "base/nearest_name.h"

namespace mm {
namespace {

/// A number in its shortest form, so that 1 and 1.0 are the same effect; other text as it is.
std::string shortest(const std::string& text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return text;
  return EffectSpec().set("", value).text("");
}

}  // namespace

plugin::Session sessionOf(const Domain& d) {
  const auto at = [](const std::vector<double>& v, std::size_t i) { return i < v.size() ? v[i] : 0.0; };
  plugin::Session session;
  for (std::size_t j = 0; j < d.joints.size(); ++j)
    session.joints.push_back(
        {d.joints[j].name, at(d.lower, j), at(d.upper, j), d.joints[j].kind == JointKind::kRotary});
  for (std::size_t s = 0; s < d.sensors.size(); ++s)
    session.sensors.push_back({d.sensors[s], at(d.sensorLower, s), at(d.sensorUpper, s), false});
  for (std::size_t c = 0; c < d.covariates.size(); ++c)
    session.covariates.push_back({d.covariates[c], at(d.covariateLower, c), at(d.covariateUpper, c), false});
  session.features = d.features;
  session.duration = d.duration;
  session.maxSpeed = d.maxSpeed;
  session.laser = d.laser;
  return session;
}

plugin::State stateOf(const State& s) {
  plugin::State state;
  state.time = s.time;
  state.position = s.position.data();
  state.velocity = s.velocity.data();
  state.travel = s.travel.data();
  state.temperature = s.temperature.data();
  state.covariate = s.covariate.data();
  for (int k = 0; k < 3; ++k) {
    state.approach[k] = s.approach[k];
    state.normal[k] = s.surfaceNormal[k];
    state.tip[k] = s.tip[k];
    for (int m = 0; m < 3; ++m) state.orientation[3 * k + m] = s.orientation(k, m);
  }
  state.laserReading = s.laserReading;
  state.feature = s.feature;
  state.featureRadius = s.featureRadius;
  return state;
}

plugin::Keys keysOf(const EffectSpec& spec, const std::vector<plugin::Key>& allowed, EffectSpec& canonical) {
  std::vector<std::string> names;
  for (const plugin::Key& key : allowed) names.push_back(key.name);
  for (const auto& [key, value] : spec.keys) {
    if (std::find(names.begin(), names.end(), key) == names.end())
      throw InputError("unknown key '" + key + "'; allowed: " + (names.empty() ? "none" : listOf(names)) +
                       didYouMean(key, names));
    if (value.list || value.items.size() != 1)
      throw InputError("key '" + key + "' must be a single value, not a list or nothing");
    if (std::count_if(spec.keys.begin(), spec.keys.end(),
                      [&k = key](const auto& other) { return other.first == k; }) > 1)
      throw InputError("key '" + key + "' is given twice; keep one");
  }
  plugin::Keys keys;
  for (const plugin::Key& key : allowed) {
    const bool given = spec.find(key.name) != nullptr;
    if (!given && key.standard.empty()) throw InputError("key '" + key.name + "' is missing; add it");
    const std::string text = shortest(given ? spec.text(key.name) : key.standard);
    if (text != shortest(key.standard)) canonical.set(key.name, text);
    keys[key.name] = text;
  }
  return keys;
}

EffectSpec specOf(const std::string& type, const plugin::Keys& keys) {
  EffectSpec spec(type);
  for (const auto& [key, value] : keys) spec.set(key, value);
  return spec;
}

State stateWithin(const Domain& domain, Random& random) {
  constexpr double kInside = 0.1;        // of a range, kept from its ends
  constexpr double kLeastSpeed = 1e-4;   // m/s or rad/s, where none was recorded
  constexpr double kReach = 0.1;         // m: a lever of a small machine
  constexpr double kUsualRadius = 4e-3;  // m, of a ball
  const auto within = [&](const std::vector<double>& lower, const std::vector<double>& upper, std::size_t n) {
    std::vector<double> v(n);
    for (std::size_t i = 0; i < n; ++i) {
      const double low = i < lower.size() ? lower[i] : 0.0, high = i < upper.size() ? upper[i] : 1.0;
      v[i] = low + random.uniform(kInside, 1.0 - kInside) * (high - low);
    }
    return v;
  };
  State state;
  const std::size_t joints = domain.joints.size();
  state.time = random.uniform(kInside, 1.0 - kInside) * domain.duration;
  state.position = within(domain.lower, domain.upper, joints);
  for (std::size_t j = 0; j < joints; ++j) {
    state.travel.push_back(random.sign());
    state.velocity.push_back(state.travel[j] * random.uniform(kInside, 1.0 - kInside) *
                             std::max(domain.maxSpeed, kLeastSpeed));
  }
  state.temperature = within(domain.sensorLower, domain.sensorUpper, domain.sensors.size());
  state.covariate = within(domain.covariateLower, domain.covariateUpper, domain.covariates.size());
  const auto any = [&] {
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return Eigen::Vector3d(x, y, z);
  };
  state.approach = -any().normalized();
  state.surfaceNormal = -state.approach;
  state.tip = kReach * any();
  state.feature = domain.features.empty() ? -1 : 0;
  state.featureRadius = domain.features.empty() ? 0.0 : kUsualRadius;
  return state;
}

}  // namespace mm
