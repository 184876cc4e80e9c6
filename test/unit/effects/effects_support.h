#pragma once
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "effects/registry.h"
#include "machine/machine.h"
#include "thermal/thermal_network.h"

namespace mm {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Collects what an effect contributes: values, derivatives, and which parameters came through `add`.
class Collector : public ErrorSink {
 public:
  Collector(int slots, int parameters, bool derivatives = true)
      : values(slots, 0.0), slopes(slots, std::vector<double>(parameters, 0.0)), derivatives_(derivatives) {}
  void add(int slot, int parameter, double value, double basis) override {
    values.at(slot) += value * basis;
    slopes.at(slot).at(parameter) += basis;
  }
  void value(int slot, double v) override { values.at(slot) += v; }
  void derivative(int slot, int parameter, double d) override { slopes.at(slot).at(parameter) += d; }
  bool wantsDerivatives() const override { return derivatives_; }

  std::vector<double> values;
  std::vector<std::vector<double>> slopes;

 private:
  bool derivatives_;
};

inline Collector evaluate(const Effect& effect, const Domain& domain, const State& state,
                          const std::vector<double>& p, bool derivatives = true) {
  Collector sink(ErrorLayout(static_cast<int>(domain.joints.size())).size(), effect.parameterCount(),
                 derivatives);
  effect.evaluate(state, p.data(), sink);
  return sink;
}

inline std::vector<double> starts(const Effect& effect) {
  std::vector<double> p;
  for (const Parameter& parameter : effect.parameters()) p.push_back(parameter.start);
  return p;
}

/// A sensor that follows a ramp, so that its lagged value is known in closed form.
class Ramp : public TemperatureHistory {
 public:
  double lagged(int sensor, double tau, double time, double* byTau) const override {
    // T = T0 + r t through a first-order lag, settled at T0: T0 + r (t - tau (1 - exp(-t/tau)))
    const double rate = 1e-3 * (sensor + 1), decay = std::exp(-time / tau);
    if (byTau != nullptr) *byTau = -rate * (1.0 - decay - decay * time / tau);
    return 21.0 + sensor + rate * (time - tau * (1.0 - decay));
  }
};

inline const char* panTiltUrdf() {
  return R"(<robot name="pan_tilt"><link name="workpiece"/><link name="fork"/><link name="tube"/><link name="probe_tip"/>
  <joint name="pan" type="revolute"><parent link="workpiece"/><child link="fork"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="tilt" type="revolute"><parent link="fork"/><child link="tube"/><origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <joint name="mount" type="fixed"><parent link="tube"/><child link="probe_tip"/><origin xyz="0.2 0.01 0"/></joint></robot>)";
}

/// A network of two sensors and three positions of the first joint that has learned a bend.
inline LearnedNetwork learnedNetwork(const Domain& d, const EffectSpec& effect) {
  Eigen::MatrixXd x(12, 2), y(12, 3);
  for (int k = 0; k < 12; ++k) {
    x.row(k) << 20.0 + k, 30.0 - 0.5 * k + k % 3;
    y.row(k) << 1e-6 * k, 2e-6 * k * k, 1e-6 * (k - x(k, 1));
  }
  const auto network = makeNetwork(NetworkKind::kRidge);
  network->fit(x, y);
  LearnedNetwork learned;
  learned.effect = effect.yaml();
  learned.active = true;
  learned.sensors = {"spindle", "bed"};
  learned.positions = {d.lower[0], 0.3 * d.lower[0] + 0.7 * d.upper[0], d.upper[0]};
  learned.numbers = network->toNumbers();
  return learned;
}

/// A domain with every kind of input, over the machine's own limits.
inline Domain domainOf(const Machine& machine, bool laser) {
  Domain d = domainOverTravel(machine);
  d.sensors = {"bed", "frame", "spindle"};
  d.sensorLower = {19, 20, 21};
  d.sensorUpper = {28, 29, 45};
  d.covariates = {"humidity", "load"};
  d.covariateLower = {38, 0};
  d.covariateUpper = {55, 100};
  d.features = {"b0", "b1", "target"};
  d.featureRadius = {0.004, 0.006, 0.0};
  d.duration = 3600;
  d.maxSpeed = 0.02;
  d.velocityLower.assign(d.joints.size(), -0.02);
  d.velocityUpper.assign(d.joints.size(), 0.015);
  d.laser = laser;
  if (laser) {
    d.readingLower = -0.5e-3;
    d.readingUpper = 0.5e-3;
  }
  return d;
}

/// What the thermal_network of its first joint learned.
inline std::vector<LearnedNetwork> networksOf(const Domain& d) {
  if (d.lower.empty()) return {};
  return {learnedNetwork(d, EffectSpec("thermal_network").set("axis", d.joints[0].name))};
}

/// A state with every input known, inside the domain.
inline State randomState(const Machine& machine, const Domain& d, std::mt19937_64& random) {
  static const Ramp ramp;
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  State s;
  s.time = d.duration * unit(random);
  for (std::size_t j = 0; j < d.joints.size(); ++j) {
    s.position.push_back(d.lower[j] + (d.upper[j] - d.lower[j]) * unit(random));
    s.travel.push_back(unit(random) < 0.5 ? -1.0 : 1.0);
    s.velocity.push_back(s.travel[j] * d.maxSpeed * (0.1 + 0.9 * unit(random)));
  }
  for (std::size_t i = 0; i < d.sensors.size(); ++i)
    s.temperature.push_back(d.sensorLower[i] + (d.sensorUpper[i] - d.sensorLower[i]) * unit(random));
  for (std::size_t i = 0; i < d.covariates.size(); ++i)
    s.covariate.push_back(d.covariateLower[i] + (d.covariateUpper[i] - d.covariateLower[i]) * unit(random));
  const ProbePose pose = machine.nominal(s.position.data(), kNan);
  s.tip = pose.position;
  s.orientation = pose.orientation;
  do s.approach = Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
  while (d.laser && -s.approach.dot(s.orientation.col(2)) > -0.2);
  s.surfaceNormal = -s.approach;
  s.laserReading = d.laser ? 1e-3 * (unit(random) - 0.5) : kNan;
  s.feature = static_cast<int>(random() % 3);
  s.featurePosition = 0.05 * Eigen::Vector3d(normal(random), normal(random), normal(random));
  s.featureRadius = d.featureRadius[s.feature];
  s.history = &ramp;
  for (std::size_t j = 0; j < d.joints.size(); ++j)
    s.sinceReversal.push_back((d.upper[j] - d.lower[j]) * unit(random));
  return s;
}

inline EffectSpec specOf(const std::string& yaml) {
  const YAML::Node node = YAML::Load(yaml);
  EffectSpec spec;
  for (const auto& entry : node) {
    const auto key = entry.first.as<std::string>();
    if (key == "type")
      spec.type = entry.second.as<std::string>();
    else if (entry.second.IsSequence())
      spec.setList(key, entry.second.as<std::vector<std::string>>());
    else
      spec.set(key, entry.second.as<std::string>());
  }
  return spec;
}

/// Three machines: 0 three_axis with a touch probe, 1 five_axis with a laser, 2 a pan-tilt head.
struct MachineRig {
  Machine machine;
  Domain domain;
};

inline MachineRig rigOf(int which) {
  if (which == 0) {
    Machine m = Machine::load("three_axis");
    Domain d = domainOf(m, false);
    return {m, d};
  }
  if (which == 1) {
    Machine m = Machine::load("five_axis");
    Domain d = domainOf(m, true);
    return {m, d};
  }
  Machine m(panTiltUrdf(), "pan_tilt");
  Domain d = domainOf(m, false);
  return {m, d};
}

/// Candidates of the whole registry, and one spec for each composite or formula that fits the machine.
inline std::vector<EffectSpec> everySpec(const Domain& domain, int which) {
  std::vector<EffectSpec> specs;
  for (const EffectType& type : effectRegistry())
    for (const EffectSpec& spec : type.candidates(domain)) specs.push_back(spec);
  const std::vector<std::string> more =
      which < 2
          ? std::vector<
                std::string>{"{type: mmt_deviation, axis: x, lead_mm: 1}",
                             "{type: mmt_deviation, axis: y, lead_mm: 1.5, exponent: 1, "
                             "amplitude_exponent: 0, argument: 1}",
                             "{type: lead_screw_periodic, axis: y, period_mm: 2.5}",
                             "{type: profile, direction: x, variable: bed}",
                             "{type: profile, direction: approach, variables: [x, y_velocity], size_um: 3}",
                             "{type: formula, direction: x, formula: k1*x*y + k2*bed}",
                             "{type: formula, direction: z, formula: k1*exp(-t/k2)*x, start: [0, 600]}",
                             "{type: formula, direction: approach, formula: k1*humidity}"}
          : std::vector<std::string>{
                "{type: formula, direction: pan, formula: k1*sin(tilt) + k2*cos(2*pan)}",
                "{type: profile, direction: pan, variables: [tilt, humidity], size_arcsec: 5}"};
  for (const std::string& text : more) specs.push_back(specOf(text));
  specs.push_back(EffectSpec("position_table").set("axis", domain.joints[0].name));
  specs.push_back(EffectSpec("straightness_table")
                      .set("axis", domain.joints[0].name)
                      .set("direction", domain.joints[1].name)
                      .set("knots", 5));
  specs.push_back(EffectSpec("thermal_network").set("axis", domain.joints[0].name));
  return specs;
}

}  // namespace mm
