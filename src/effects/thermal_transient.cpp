#include "effects/thermal_transient.h"

#include <algorithm>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

class ThermalTransient : public CatalogueEffect {
 public:
  explicit ThermalTransient(SpecReader& read) : ThermalTransient(read, read.direction("direction")) {}

  bool linear() const override { return false; }
  std::vector<int> nonlinearParameters() const override { return {1}; }
  std::vector<std::vector<double>> searchStarts() const override { return starts_; }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double temperature = state.temperature[sensor_];
    double lagged = temperature, byTau = 0.0;
    if (state.history == nullptr)
      lagged = kUnknown;
    else if (p[1] > 0.0 && temperature == temperature)
      lagged = state.history->lagged(sensor_, p[1], state.time, &byTau);
    sink.add(slot_, 0, p[0], temperature - lagged);
    if (sink.wantsDerivatives()) sink.derivative(slot_, 1, -p[0] * byTau);
  }

  /// Behind a slower one nothing has come to rest: it is growth with the temperature, less a constant.
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || nonlinear.front() <= slowest_;
  }

  std::string cause() const override {
    return "While " + sensorName_ +
           " warms or cools, parts of unequal thickness or material follow it unequally fast and displace "
           "the "
           "probe or the artifact along " +
           direction_ + "; when it rests they agree again.";
  }
  std::string remedy() const override {
    return "Change " + sensorName_ +
           " slowly, or wait until it rests before measuring; join parts that follow alike, or leave the "
           "correction on.";
  }
  std::string shownBy() const override {
    return "The same positions measured while " + sensorName_ + " rises, while it falls and while it rests.";
  }

 private:
  ThermalTransient(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        sensor_(read.sensor("sensor")),
        direction_(direction.name),
        sensorName_(read.domain().sensors[sensor_]) {
    const bool linear = direction.quantity == JointKind::kLinear;
    parameters_ = {parameter("growth", errorUnit(direction.quantity) / kUnitKelvin,
                             linear ? 1e-6 : kArcsecond, linear ? 200e-6 : 1e-3),
                   timeConstant("time_constant", read.domain())};
    slowest_ = std::max(read.domain().duration, 1.0) / 4.0;
    for (const std::vector<double>& start : timeConstantStarts(read.domain()))
      if (start.front() <= slowest_) starts_.push_back(start);
  }

  int slot_, sensor_;
  std::string direction_, sensorName_;
  std::vector<std::vector<double>> starts_;
  double slowest_ = 0.0;  // s
};

}  // namespace

EffectType thermalTransientType() {
  return effectType<ThermalTransient>("thermal_transient", {"direction", "sensor"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& direction : directionNames(domain))
      for (const std::string& sensor : domain.sensors)
        specs.push_back(EffectSpec("thermal_transient").set("direction", direction).set("sensor", sensor));
    return specs;
  });
}

}  // namespace mm
