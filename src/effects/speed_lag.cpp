#include "effects/speed_lag.h"

#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class SpeedLag : public CatalogueEffect {
 public:
  explicit SpeedLag(SpecReader& read) : CatalogueEffect(read, Stage::kAxis) {
    for (int j = 0; j < layout_.joints(); ++j) moved_.push_back(observedRange(read.domain(), j) > 0.0);
    parameters_ = {parameter("delay", {"ms", 1e3}, 1e-3, 1.0)};
    parameters_[0].seldomNegative = true;
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    for (int j = 0; j < layout_.joints(); ++j) {
      const double velocity = state.velocity[j];
      // a joint that the session never moved stands still, also where its velocity was not logged
      sink.add(layout_.axis(j), 0, p[0], std::isnan(velocity) && !moved_[j] ? 0.0 : -velocity);
    }
  }

  double met() const override { return 0.3; }  // most controllers latch in hardware

  std::string cause() const override {
    return "The trigger signal is delayed (probe, filter, cable): the readings are latched after the "
           "contact, further along the motion.";
  }
  std::string remedy() const override {
    return "Latch the position in hardware at the trigger, or always touch at one low speed and calibrate at "
           "that speed.";
  }
  std::string shownBy() const override {
    return "Contacts at the same places with at least two different approach speeds, velocities recorded.";
  }

 private:
  std::vector<char> moved_;
};

}  // namespace

EffectType speedLagType() {
  return effectType<SpeedLag>("speed_lag", {}, [](const Domain&) {
    std::vector<EffectSpec> specs;
    specs.emplace_back("speed_lag");
    return specs;
  });
}

}  // namespace mm
