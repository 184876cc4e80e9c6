#include "effects/warm_up.h"

#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

class WarmUp : public CatalogueEffect {
 public:
  explicit WarmUp(SpecReader& read) : WarmUp(read, read.direction("direction")) {}

  bool linear() const override { return false; }
  std::vector<int> nonlinearParameters() const override { return {1}; }
  std::vector<std::vector<double>> searchStarts() const override { return starts_; }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double tau = p[1], t = state.time;
    if (tau <= 0.0)
      return sink.add(slot_, 0, p[0], t > 0.0 ? 1.0 : 0.0);  // the limit of a short time constant
    const double decay = std::exp(-t / tau);
    sink.add(slot_, 0, p[0], -std::expm1(-t / tau));
    if (sink.wantsDerivatives()) sink.derivative(slot_, 1, -p[0] * decay * t / (tau * tau));
  }

  /// Of a slower one the session saw hardly more than a straight line, which is a steady drift.
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || nonlinear.front() <= slowest_;
  }
  /// A machine has more than one time constant: behind the quick one it still creeps.
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    return {{EffectSpec("time_drift").set("direction", direction_)}};
  }

  std::string cause() const override {
    return "The machine warms up after it is switched on and drifts along " + direction_ +
           ", quickly at first, towards a steady state.";
  }
  std::string remedy() const override {
    return "Let the machine warm up before measuring (three time constants), or leave the correction on and "
           "start every session in the same way.";
  }
  std::string shownBy() const override {
    return "The same positions measured often at the beginning, and until they are steady.";
  }

 private:
  WarmUp(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction), slot_(direction.slot(layout_)), direction_(direction.name) {
    parameters_ = {errorParameter("amplitude", direction.quantity),
                   timeConstant("time_constant", read.domain())};
    starts_ = timeConstantStarts(read.domain());
    slowest_ = starts_.back().front();
  }

  int slot_;
  std::string direction_;
  std::vector<std::vector<double>> starts_;
  double slowest_ = 0.0;  // s
};

}  // namespace

EffectType warmUpType() {
  return effectType<WarmUp>("warm_up", {"direction"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& direction : directionNames(domain))
      specs.push_back(EffectSpec("warm_up").set("direction", direction));
    return specs;
  });
}

}  // namespace mm
