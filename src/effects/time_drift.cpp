#include "effects/time_drift.h"

#include <algorithm>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class TimeDrift : public CatalogueEffect {
 public:
  explicit TimeDrift(SpecReader& read) : TimeDrift(read, read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(slot_, 0, p[0], state.time);
  }

  std::string cause() const override {
    return "Steady drift along " + direction_ +
           " during the session: a fixture that settles, an adhesive that creeps, a slow change of "
           "temperature.";
  }
  std::string remedy() const override {
    return "Repeat a reference measurement at intervals, look for the loose or creeping part, or shorten the "
           "session.";
  }
  std::string shownBy() const override {
    return "The same positions measured repeatedly over the whole session, in changing order.";
  }

 private:
  TimeDrift(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction), slot_(direction.slot(layout_)), direction_(direction.name) {
    const double duration = std::max(read.domain().duration, 1.0);
    const Parameter whole = errorParameter("rate", direction.quantity);
    parameters_ = {parameter("rate", errorUnit(direction.quantity) / kUnitHour, whole.scale / duration,
                             whole.bound / duration)};
  }

  int slot_;
  std::string direction_;
};

}  // namespace

EffectType timeDriftType() {
  return effectType<TimeDrift>("time_drift", {"direction"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& direction : directionNames(domain))
      specs.push_back(EffectSpec("time_drift").set("direction", direction));
    return specs;
  });
}

}  // namespace mm
