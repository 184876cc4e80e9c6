#include "effects/thermal_expansion.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class ThermalExpansion : public CatalogueEffect {
 public:
  explicit ThermalExpansion(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")), sensor_(read.sensor("sensor")) {
    const Joint& joint = read.domain().joints[axis_];
    name_ = joint.name;
    sensorName_ = read.domain().sensors[sensor_];
    parameters_ = {expansionParameter(errorUnit(joint.kind) / readingUnit(joint.kind) / kUnitKelvin)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(axis_), 0, p[0],
             state.position[axis_] * (state.temperature[sensor_] - kReferenceTemperature));
  }

  /// No bed warms evenly along its length.
  std::vector<int> variesAlong(const Domain&) const override { return {axis_}; }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "The scale or screw of " + name_ + " expands with the temperature " + sensorName_ +
           ": the error of a length along it is proportional to the length.";
  }
  std::string remedy() const override {
    return "Measure near 20 degC, use a scale of low expansion, or leave the correction on with the sensor " +
           sensorName_ + " at the scale.";
  }
  std::string shownBy() const override {
    return "Lengths along " + name_ + " measured at different temperatures of " + sensorName_ + ".";
  }

 private:
  int axis_, sensor_;
  std::string name_, sensorName_;
};

}  // namespace

EffectType thermalExpansionType() {
  return effectType<ThermalExpansion>("thermal_expansion", {"axis", "sensor"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain))
      for (const std::string& sensor : domain.sensors)
        specs.push_back(EffectSpec("thermal_expansion").set("axis", joint).set("sensor", sensor));
    return specs;
  });
}

}  // namespace mm
