#include "effects/rotary_wobble.h"

#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/rotary.h"

namespace mm {
namespace {

class RotaryWobble : public CatalogueEffect {
 public:
  explicit RotaryWobble(SpecReader& read)
      : CatalogueEffect(read, Stage::kJoint),
        joint_(read.joint("joint", JointKind::kRotary)),
        radial_(read, joint_) {
    harmonic_ = read.integer("harmonic", 1, kHighestHarmonic);
    name_ = read.domain().joints[joint_].name;
    turn_ = harmonic_ == 1 ? "turn" : "1/" + std::to_string(harmonic_) + " turn";
    for (const std::string& direction : radial_.names)
      for (const char* phase : {"cos", "sin"})
        parameters_.push_back(errorParameter(direction + "_" + phase, JointKind::kRotary));
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double angle = harmonic_ * state.position[joint_];
    const double cosine = std::cos(angle), sine = std::sin(angle);
    for (int d = 0; d < 2; ++d)
      for (int k = 0; k < 3; ++k) {
        if (radial_.directions[d][k] == 0.0) continue;
        sink.add(layout_.jointRotation(joint_, k), 2 * d, p[2 * d], cosine * radial_.directions[d][k]);
        sink.add(layout_.jointRotation(joint_, k), 2 * d + 1, p[2 * d + 1], sine * radial_.directions[d][k]);
      }
  }

  std::vector<std::string> shapeKeys() const override { return {"harmonic"}; }
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    return otherHarmonics(spec(), harmonic_, kHighestHarmonic);
  }
  std::vector<int> mustMove() const override { return {joint_}; }

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

 private:
  int joint_;
  RadialDirections radial_;
  int harmonic_ = 1;
  std::string name_, turn_;
};

}  // namespace

EffectType rotaryWobbleType() {
  return effectType<RotaryWobble>("rotary_wobble", {"joint", "harmonic"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain, JointKind::kRotary))
      for (int harmonic = 1; harmonic <= 3; ++harmonic)
        specs.push_back(EffectSpec("rotary_wobble").set("joint", joint).set("harmonic", harmonic));
    return specs;
  });
}

}  // namespace mm
