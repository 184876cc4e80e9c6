#include "effects/tip_wear.h"

#include <algorithm>
#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

class TipWear : public CatalogueEffect {
 public:
  explicit TipWear(SpecReader& read)
      : CatalogueEffect(read, Stage::kProbe), slows_(read.flag("slows", false)) {
    const double duration = std::max(read.domain().duration, 1.0);
    const Parameter whole = errorParameter(slows_ ? "depth" : "rate", JointKind::kLinear);
    if (slows_) {
      parameters_ = {whole, timeConstant("time_constant", read.domain())};
      starts_ = timeConstantStarts(read.domain());
      slowest_ = starts_.back().front();
    } else {
      parameters_ = {parameter("rate", errorUnit(JointKind::kLinear) / kUnitHour, whole.scale / duration,
                               whole.bound / duration)};
    }
    parameters_[0].seldomNegative = true;  // a tip that picks something up
  }

  bool linear() const override { return !slows_; }
  std::vector<int> nonlinearParameters() const override {
    return slows_ ? std::vector<int>{1} : std::vector<int>{};
  }
  std::vector<std::vector<double>> searchStarts() const override { return starts_; }
  std::vector<std::string> shapeKeys() const override { return {"slows"}; }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (!slows_) return sink.add(layout_.distance(), 0, p[0], -state.time);
    const double tau = p[1], t = state.time;
    if (tau <= 0.0) return sink.add(layout_.distance(), 0, p[0], t > 0.0 ? -1.0 : 0.0);
    sink.add(layout_.distance(), 0, p[0], std::expm1(-t / tau));
    if (sink.wantsDerivatives())
      sink.derivative(layout_.distance(), 1, p[0] * std::exp(-t / tau) * t / (tau * tau));
  }

  /// Of one that slows down later the session saw hardly more than a steady wear.
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || nonlinear.front() <= slowest_;
  }
  /// The quick wear of a new tip leaves the steady one.
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    if (!slows_) return {};
    return {{EffectSpec("tip_wear")}};
  }

  std::string cause() const override {
    return std::string("The effective radius of the tip shrinks during the session, ") +
           (slows_ ? "quickly at first" : "steadily") + ": the tip wears. Where it grows (a negative " +
           parameters_[0].name +
           "), the tip picks up material or dirt, or the pre-travel of the probe grows.";
  }
  std::string remedy() const override {
    return "Look at the tip under a microscope, clean or replace it (another material than that of the "
           "artifact), and qualify it before and after a session.";
  }
  std::string shownBy() const override {
    return "A ball of known radius measured from all sides repeatedly over the whole session.";
  }

 private:
  bool slows_;
  std::vector<std::vector<double>> starts_;
  double slowest_ = 0.0;  // s
};

}  // namespace

EffectType tipWearType() {
  return effectType<TipWear>("tip_wear", {"slows"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (!domain.laser && domain.duration > 0.0 && !ballNames(domain).empty())
      specs = {EffectSpec("tip_wear"), EffectSpec("tip_wear").set("slows", "true")};
    return specs;
  });
}

}  // namespace mm
