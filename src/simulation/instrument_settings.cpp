#include "simulation/instrument_settings.h"

#include <yaml-cpp/yaml.h>

#include <cmath>

#include "base/error.h"
#include "base/format.h"
#include "base/yaml_mapping.h"

namespace mm {
namespace {

constexpr double kAny = 1e9;
constexpr double kMinute = 60.0, kHour = 3600.0;

/// Sets a value when the key is there.
void set(const YamlMapping& map, const std::string& key, double factor, double lower, double upper,
         double& value) {
  if (map.has(key)) value = map.number(key, factor, lower, upper);
}

void readNoise(const YamlMapping& map, NoiseSettings& noise) {
  set(map, "repeatability_um", kMicrometre, 0.0, kAny, noise.repeatability);
  set(map, "angular_repeatability_arcsec", kArcsecond, 0.0, kAny, noise.angularRepeatability);
  set(map, "student_dof", 1.0, 0.5, kAny, noise.studentDof);
  set(map, "missing_velocities", 1.0, 0.0, 1.0, noise.missingVelocityShare);
  set(map, "reference_um", kMicrometre, 0.0, kAny, noise.reference);
  set(map, "reference_arcsec", kArcsecond, 0.0, kAny, noise.referenceAngular);
  set(map, "laser_um", kMicrometre, 0.0, kAny, noise.laser);
  set(map, "laser_dropout", 1.0, 0.0, 1.0, noise.laserDropoutShare);
  set(map, "temperature_K", 1.0, 0.0, kAny, noise.temperature);
  if (!map.has("outliers")) return;
  const YamlMapping outliers(map.node("outliers"), map.source(), "outliers", {"share", "size_um"});
  noise.outlierShare = outliers.number("share", 1.0, 0.0, 1.0);
  set(outliers, "size_um", kMicrometre, 0.0, kAny, noise.outlierSize);
}

void readLaser(const YamlMapping& map, LaserSettings& laser) {
  if (map.has("range_mm")) {
    const std::vector<double> range = map.numbers("range_mm", kMillimetre);
    if (range.size() != 2 || range[1] <= range[0]) map.fail("range_mm", "must be two readings, [from, to]");
    laser.rangeLower = range[0];
    laser.rangeUpper = range[1];
  }
  set(map, "max_incidence_deg", kDegree, 1.0, 90.0, laser.maxIncidence);
}

void readPlacement(const YamlMapping& map, PlacementSettings& placement) {
  set(map, "shift_mm", kMillimetre, 0.0, kAny, placement.shift);
  set(map, "turn_deg", kDegree, 0.0, kAny, placement.turn);
  set(map, "free_centres_mm", kMillimetre, 0.0, kAny, placement.freeCentres);
}

/// Keys from_min and to_min, which keeps its value where the key is missing.
void setPeriod(const YamlMapping& map, double& from, double& to) {
  set(map, "from_min", kMinute, 0.0, kAny, from);
  set(map, "to_min", kMinute, 0.0, kAny, to);
  if (to < from)
    map.fail("to_min",
             format("is %.6g, before from_min %.6g; give a later one", to / kMinute, from / kMinute));
}

HeatSchedule readHeat(const YAML::Node& node, const std::string& source, const ThermalModel& bodies) {
  const YamlMapping map(node, source, "heat", {"body", "power_W", "from_min", "to_min", "every_min"});
  HeatSchedule heat;
  heat.body = bodies.findBody(map.text("body"));
  if (heat.body < 0 || heat.body == bodies.bodyCount() - 1) map.fail("body", "must be motor, frame or bed");
  heat.power = map.number("power_W", 1.0, -kAny, kAny);
  heat.to = kAny;
  setPeriod(map, heat.from, heat.to);
  set(map, "every_min", kMinute, 1e-3, kAny, heat.every);
  return heat;
}

void readThermal(const YamlMapping& map, ThermalSettings& thermal) {
  const ThermalModel bodies = InstrumentSettings().thermalModel();
  set(map, "sensor_lag_s", 1.0, 0.0, kAny, thermal.sensorLag);
  set(map, "log_period_s", 1.0, 0.01, kAny, thermal.logPeriod);
  if (map.has("sensors")) {
    thermal.sensors = map.texts("sensors");
    for (const std::string& name : thermal.sensors)
      if (bodies.findBody(name) < 0)
        map.fail("sensors", "names '" + name + "'; possible are motor, frame, bed, air");
  }
  if (map.has("ambient")) {
    const YamlMapping ambient(map.node("ambient"), map.source(), "ambient",
                              {"start_degC", "ramp_K_per_h", "swing_K", "swing_period_min"});
    set(ambient, "start_degC", 1.0, -100.0, 200.0, thermal.ambient.start);
    set(ambient, "ramp_K_per_h", 1.0 / kHour, -100.0, 100.0, thermal.ambient.ramp);
    set(ambient, "swing_K", 1.0, -50.0, 50.0, thermal.ambient.swing);
    set(ambient, "swing_period_min", kMinute, 0.1, kAny, thermal.ambient.period);
  }
  if (!map.has("heat")) return;
  if (!map.node("heat").IsSequence()) map.fail("heat", "must be a list such as [{body: bed, power_W: 3}]");
  for (const YAML::Node& node : map.node("heat"))
    thermal.heat.push_back(readHeat(node, map.source(), bodies));
}

std::string flowText(const YAML::Node& node) {
  YAML::Emitter out;
  out << YAML::Flow << node;
  return out.c_str();
}

TrueCovariate readCovariate(const YAML::Node& node, const std::string& source) {
  const YamlMapping map(node, source, "a covariate",
                        {"name", "unit", "mean", "swing", "period_min", "from_min", "to_min"});
  TrueCovariate covariate;
  covariate.name = map.text("name");
  covariate.unit = map.text("unit");
  set(map, "mean", 1.0, -kAny, kAny, covariate.mean);
  set(map, "swing", 1.0, -kAny, kAny, covariate.swing);
  set(map, "period_min", kMinute, 0.1, kAny, covariate.period);
  setPeriod(map, covariate.from, covariate.to);
  return covariate;
}

}  // namespace

ThermalModel InstrumentSettings::thermalModel() const {
  return ThermalModel(ThermalModel::usualBodies(), ThermalModel::usualContacts(), thermal.heat,
                      thermal.ambient);
}

InstrumentSettings InstrumentSettings::parse(const std::string& planYaml, const std::string& source) {
  InstrumentSettings settings;
  const YAML::Node plan = YamlMapping::load(planYaml, source);
  if (plan["probe"] && plan["probe"].IsScalar()) settings.laser.present = plan["probe"].Scalar() == "laser";
  if (!plan["instrument"]) return settings;
  const YamlMapping map(plan["instrument"], source, "instrument",
                        {"noise", "laser", "placement", "thermal", "covariates", "errors", "rough"});
  const auto section = [&](const char* name, const std::vector<std::string>& keys, auto read, auto& into) {
    if (map.has(name)) read(YamlMapping(map.node(name), source, name, keys), into);
  };
  section("noise",
          {"repeatability_um", "angular_repeatability_arcsec", "student_dof", "missing_velocities",
           "reference_um", "reference_arcsec", "laser_um", "laser_dropout", "temperature_K", "outliers"},
          readNoise, settings.noise);
  section("laser", {"range_mm", "max_incidence_deg"}, readLaser, settings.laser);
  section("placement", {"shift_mm", "turn_deg", "free_centres_mm"}, readPlacement, settings.placement);
  section("thermal", {"sensor_lag_s", "log_period_s", "sensors", "ambient", "heat"}, readThermal,
          settings.thermal);
  if (map.has("covariates")) {
    if (!map.node("covariates").IsSequence()) map.fail("covariates", "must be a list");
    for (const YAML::Node& node : map.node("covariates"))
      settings.covariates.push_back(readCovariate(node, source));
  }
  if (map.has("rough")) settings.rough = Roughness::read(map.node("rough"), source);
  if (map.has("errors")) {
    if (!map.node("errors").IsSequence())
      map.fail("errors", "must be a list of sources, written as for --hide");
    for (const YAML::Node& node : map.node("errors"))
      settings.errors.push_back(node.IsScalar() ? node.Scalar() : flowText(node));
  }
  return settings;
}

}  // namespace mm
