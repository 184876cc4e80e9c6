#include "effects/thermal_growth.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

class ThermalGrowth : public CatalogueEffect {
 public:
  explicit ThermalGrowth(SpecReader& read) : ThermalGrowth(read, read.direction("direction")) {}

  bool linear() const override { return !lag_; }
  std::vector<int> nonlinearParameters() const override {
    return lag_ ? std::vector<int>{1} : std::vector<int>{};
  }
  std::vector<std::vector<double>> searchStarts() const override { return starts_; }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double temperature = state.temperature[sensor_];
    if (!lag_) return sink.add(slot_, 0, p[0], temperature - kReferenceTemperature);
    double lagged = temperature, byTau = 0.0;
    if (state.history == nullptr)
      lagged = kUnknown;
    else if (p[1] > 0.0 && temperature == temperature)
      lagged = state.history->lagged(sensor_, p[1], state.time, &byTau);
    sink.add(slot_, 0, p[0], lagged - kReferenceTemperature);
    if (sink.wantsDerivatives()) sink.derivative(slot_, 1, p[0] * byTau);
  }

  std::vector<std::string> shapeKeys() const override { return {"lag"}; }
  /// Of a part that follows late some is near the sensor, and follows at once.
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    if (!lag_) return {};
    EffectSpec atOnce(spec().type);
    return {{atOnce.set("direction", direction_).set("sensor", sensorName_)}};
  }

  std::string cause() const override {
    return "The part at the sensor " + sensorName_ +
           " expands with temperature and displaces the probe or the artifact along " + direction_ +
           (lag_ ? ", some time after the sensor warms." : ".");
  }
  std::string remedy() const override {
    return "Keep " + sensorName_ +
           " steady (warm up before measuring, screen or cool the source), or leave the correction on.";
  }
  std::string shownBy() const override {
    return "The same positions measured at different temperatures of " + sensorName_ +
           (lag_ ? ", with a quick change and the time after it."
                 : ", rising and falling, so that it is not correlated with time.");
  }

 private:
  ThermalGrowth(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        sensor_(read.sensor("sensor")),
        lag_(read.flag("lag", false)),
        direction_(direction.name),
        sensorName_(read.domain().sensors[sensor_]) {
    const bool linear = direction.quantity == JointKind::kLinear;
    parameters_ = {parameter("growth", errorUnit(direction.quantity) / kUnitKelvin,
                             linear ? 1e-6 : kArcsecond, linear ? 200e-6 : 1e-3)};
    if (!lag_) return;
    parameters_.push_back(timeConstant("time_constant", read.domain()));
    starts_ = timeConstantStarts(read.domain());
  }

  int slot_, sensor_;
  bool lag_;
  std::string direction_, sensorName_;
  std::vector<std::vector<double>> starts_;
};

}  // namespace

EffectType thermalGrowthType() {
  return effectType<ThermalGrowth>(
      "thermal_growth", {"direction", "sensor", "lag"}, [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        for (const char* lag : {"", "true"})
          for (const std::string& direction : directionNames(domain))
            for (const std::string& sensor : domain.sensors) {
              specs.push_back(EffectSpec("thermal_growth").set("direction", direction).set("sensor", sensor));
              if (*lag != '\0') specs.back().set("lag", lag);
            }
        return specs;
      });
}

}  // namespace mm
