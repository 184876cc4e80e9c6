// What temperatures do to the machine.
#include <algorithm>

#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/tilt.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

/// The zero of a sensor on a part is off by some tenths of a kelvin, and a session sees one or two: of what
/// a temperature does, so much is there at all times.
constexpr double kZeroOfSensor = 0.2;

/// Response of a first-order lag to a sensor, degC, and its derivative by the time constant.
double lagged(const State& s, int sensor, double timeConstant, double* byTimeConstant) {
  const double temperature = s.temperature[sensor];
  *byTimeConstant = 0.0;
  if (s.history == nullptr) return kUnknown;
  if (!(timeConstant > 0.0) || temperature != temperature) return temperature;
  return s.history->lagged(sensor, timeConstant, s.time, byTimeConstant);
}

/// What a body does that has the temperature of a sensor, or with the key `lag` follows it after a lag.
/// @param of the state, by which the temperature is multiplied. @param atOnce the same without a lag.
template <typename Factor>
Law followingSensor(SpecReader& read, Stage stage, int slot, Parameter size, const EffectSpec& atOnce,
                    Factor of) {
  const int sensor = read.sensor("sensor");
  const bool late = read.flag("lag", false);
  Law law = oneTerm(stage, slot, std::move(size), [sensor, of](const State& s) {
    return of(s) * (s.temperature[sensor] - kReferenceTemperature);
  });
  law.nature.shapeKeys = {"lag"};
  if (!late) return law;
  law.parameters.push_back(timeConstant("time_constant", read.domain()));
  law.starts = timeConstantStarts(read.domain());
  law.add = [sensor, slot, of](const State& s, const double* p, ErrorSink& sink) {
    double byTau = 0.0;
    sink.add(slot, 0, p[0], of(s) * (lagged(s, sensor, p[1], &byTau) - kReferenceTemperature));
    if (sink.wantsDerivatives()) sink.derivative(slot, 1, p[0] * of(s) * byTau);
  };
  // of a part that follows late some is near the sensor, and follows at once
  law.freedom = {{EffectSpec(atOnce).set("sensor", read.domain().sensors[sensor])}};
  law.variant = "with lag";
  return law;
}

Law thermalExpansion(SpecReader& read) {
  const int axis = read.joint("axis");
  const Joint& joint = read.jointAt(axis);
  Law law = followingSensor(read, Stage::kAxis, read.layout().axis(axis),
                            expansionParameter(errorUnit(joint.kind) / readingUnit(joint.kind) / kUnitKelvin),
                            EffectSpec("thermal_expansion").set("axis", joint.name),
                            [axis](const State& s) { return s.position[axis]; });
  law.nature.variesAlong = law.nature.mustMove = {axis};  // no bed warms evenly along its length
  law.freedom.push_back({EffectSpec("scale").set("axis", joint.name), kZeroOfSensor});
  return law;
}

Parameter growthParameter(JointKind kind) {
  const bool linear = kind == JointKind::kLinear;
  return parameter("growth", errorUnit(kind) / kUnitKelvin, linear ? 1e-6 : kArcsecond,
                   linear ? 200e-6 : 1e-3);
}

Law thermalGrowth(SpecReader& read) {
  const Direction direction = read.direction("direction");
  return followingSensor(
      read, stageOf(direction), direction.slot(read.layout()), growthParameter(direction.quantity),
      EffectSpec("thermal_growth").set("direction", direction.name), [](const State&) { return 1.0; });
}

Law thermalBending(SpecReader& read) {
  read.joint("axis");
  const int about = read.axisOf("about");
  const auto [first, second] = read.sensorPair("sensors");
  Law law;
  law.nature.stage = Stage::kVolume;
  law.parameters = {parameter("bending", kUnitArcsecond / kUnitKelvin, kArcsecond, 1e-3)};
  law.add = [layout = read.layout(), about, a = first, b = second](const State& s, const double* p,
                                                                   ErrorSink& sink) {
    addTilt(layout, about, s, 0, p[0], s.temperature[a] - s.temperature[b], sink);
  };
  for (const Joint& one : read.domain().joints)
    for (const Joint& of : read.domain().joints)
      if (one.name != of.name && isAcross(one, about) && isAcross(of, about))
        law.freedom.push_back(
            {EffectSpec("squareness").set("axis", one.name).set("of", of.name), kZeroOfSensor});
  return law;
}

/// Which member bends does not change the displacement: one is offered, the column that carries z where there
/// is one.
std::vector<std::string> bendingMember(const Domain& domain) {
  if (domain.joints.empty()) return {};
  return {domain.findJoint("z") >= 0 ? "z" : domain.joints.front().name};
}

Values::List pairsOfSensors(const Domain& domain) {
  Values::List pairs;
  for (std::size_t a = 0; a < domain.sensors.size(); ++a)
    for (std::size_t b = a + 1; b < domain.sensors.size(); ++b)
      pairs.push_back({{domain.sensors[a], domain.sensors[b]}, true});
  return pairs;
}

Law thermalTransient(SpecReader& read) {
  const Direction direction = read.direction("direction");
  const int sensor = read.sensor("sensor"), slot = direction.slot(read.layout());
  Law law;
  law.nature.stage = stageOf(direction);
  law.parameters = {growthParameter(direction.quantity), timeConstant("time_constant", read.domain())};
  law.add = [sensor, slot](const State& s, const double* p, ErrorSink& sink) {
    double byTau = 0.0;
    sink.add(slot, 0, p[0], s.temperature[sensor] - lagged(s, sensor, p[1], &byTau));
    if (sink.wantsDerivatives()) sink.derivative(slot, 1, -p[0] * byTau);
  };
  // behind a slower one nothing has come to rest: it is growth with the temperature, less a constant
  law.longest = std::max(read.domain().duration, 1.0) / 4.0;
  for (const double start : timeConstantStarts(read.domain()))
    if (start <= law.longest) law.starts.push_back(start);
  return law;
}

}  // namespace

std::vector<LawRow> lawsOfTemperature() {
  return {
      {"thermal_expansion",
       {"axis", "sensor", "lag"},
       {fixed("lag", {"", "true"}), joints("axis"), sensors()},
       {},
       thermalExpansion},
      {"thermal_growth",
       {"direction", "sensor", "lag"},
       {fixed("lag", {"", "true"}), directions(), sensors()},
       {},
       thermalGrowth},
      {"thermal_bending",
       {"axis", "about", "sensors"},
       {named("axis", bendingMember), fixed("about", {"x", "y", "z"}), {"sensors", pairsOfSensors}},
       {},
       thermalBending},
      {"thermal_transient", {"direction", "sensor"}, {directions(), sensors()}, {}, thermalTransient},
  };
}

}  // namespace mm
