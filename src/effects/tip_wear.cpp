#include "effects/tip_wear.h"

#include <algorithm>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class TipWear : public CatalogueEffect {
 public:
  explicit TipWear(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    const double duration = std::max(read.domain().duration, 1.0);
    const Parameter whole = errorParameter("rate", JointKind::kLinear);
    parameters_ = {parameter("rate", errorUnit(JointKind::kLinear) / kUnitHour, whole.scale / duration,
                             whole.bound / duration)};
    parameters_[0].seldomNegative = true;  // a tip that picks something up
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.distance(), 0, p[0], -state.time);
  }

  std::string cause() const override {
    return "The effective radius of the tip shrinks steadily during the session: the tip wears. Where it "
           "grows (a negative rate), the tip picks up material or dirt, or the pre-travel of the probe "
           "grows.";
  }
  std::string remedy() const override {
    return "Look at the tip under a microscope, clean or replace it (another material than that of the "
           "artifact), and qualify it before and after a session.";
  }
  std::string shownBy() const override {
    return "A ball of known radius measured from all sides repeatedly over the whole session.";
  }
};

}  // namespace

EffectType tipWearType() {
  return effectType<TipWear>("tip_wear", {}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (!domain.laser && domain.duration > 0.0 && !ballNames(domain).empty()) specs.emplace_back("tip_wear");
    return specs;
  });
}

}  // namespace mm
