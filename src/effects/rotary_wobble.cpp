#include "effects/rotary_wobble.h"

#include "effects/quantity.h"
#include "effects/rotary.h"

namespace mm {
namespace {

class RotaryWobble : public RotaryWave {
 public:
  explicit RotaryWobble(SpecReader& read) : RotaryWave(read, JointKind::kRotary) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    addRadial(state, p, sink, [this](int k) { return layout_.jointRotation(joint_, k); });
  }

  std::string cause() const override {
    return "Tilt error motion of the axis of " + name_ + " (ISO 230-7), once every " + turn_ +
           ": bearing faces that are not square or not flat.";
  }
  std::string remedy() const override {
    return "Check preload and squareness of the bearings of " + name_ +
           "; keep the measuring point close to the bearing.";
  }
  std::string shownBy() const override {
    return "Contacts at different distances from the bearing of " + name_ + ", at many of its angles.";
  }
};

}  // namespace

EffectType rotaryWobbleType() {
  return effectType<RotaryWobble>("rotary_wobble", {"joint", "harmonic"}, [](const Domain& domain) {
    return rotaryHarmonics("rotary_wobble", domain);
  });
}

}  // namespace mm
