#include "effects/rotary_eccentricity.h"

#include <cmath>

#include "effects/quantity.h"
#include "effects/rotary.h"

namespace mm {
namespace {

class RotaryEccentricity : public RotaryWave {
 public:
  explicit RotaryEccentricity(SpecReader& read) : RotaryWave(read, JointKind::kLinear) {
    for (const char* phase : {"cos", "sin"})
      parameters_.push_back(errorParameter(std::string("reading_") + phase, JointKind::kRotary));
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    addRadial(state, p, sink, [this](int k) { return layout_.jointTranslation(joint_, k); });
    sink.add(layout_.axis(joint_), 4, p[4], std::cos(phase(state)));
    sink.add(layout_.axis(joint_), 5, p[5], std::sin(phase(state)));
  }

  std::string cause() const override {
    return "Radial error motion of the bearing, or eccentricity of the scale, of " + name_ + ": once every " +
           turn_ + " the axis moves sideways and the scale reads ahead and behind.";
  }
  std::string remedy() const override {
    return "Centre the scale of " + name_ +
           " on its bearing (or read it with two opposite heads), and check the bearing's seat.";
  }
  std::string shownBy() const override {
    return "Readings or contacts at many angles of " + name_ +
           ", over more than one cycle of the harmonic where the joint allows it.";
  }
};

}  // namespace

EffectType rotaryEccentricityType() {
  return effectType<RotaryEccentricity>(
      "rotary_eccentricity", {"joint", "harmonic"},
      [](const Domain& domain) { return rotaryHarmonics("rotary_eccentricity", domain); });
}

}  // namespace mm
