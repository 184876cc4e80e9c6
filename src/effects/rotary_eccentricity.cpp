#include "effects/rotary_eccentricity.h"

#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/rotary.h"

namespace mm {
namespace {

class RotaryEccentricity : public CatalogueEffect {
 public:
  explicit RotaryEccentricity(SpecReader& read)
      : CatalogueEffect(read, Stage::kJoint),
        joint_(read.joint("joint", JointKind::kRotary)),
        radial_(read, joint_) {
    harmonic_ = read.integer("harmonic", 1, kHighestHarmonic);
    name_ = read.domain().joints[joint_].name;
    turn_ = harmonic_ == 1 ? "turn" : "1/" + std::to_string(harmonic_) + " turn";
    for (const std::string& direction : radial_.names)
      for (const char* phase : {"cos", "sin"})
        parameters_.push_back(errorParameter(direction + "_" + phase, JointKind::kLinear));
    for (const char* phase : {"cos", "sin"})
      parameters_.push_back(errorParameter(std::string("reading_") + phase, JointKind::kRotary));
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double angle = harmonic_ * state.position[joint_];
    const double cosine = std::cos(angle), sine = std::sin(angle);
    for (int d = 0; d < 2; ++d)
      for (int k = 0; k < 3; ++k) {
        if (radial_.directions[d][k] == 0.0) continue;
        sink.add(layout_.jointTranslation(joint_, k), 2 * d, p[2 * d], cosine * radial_.directions[d][k]);
        sink.add(layout_.jointTranslation(joint_, k), 2 * d + 1, p[2 * d + 1],
                 sine * radial_.directions[d][k]);
      }
    sink.add(layout_.axis(joint_), 4, p[4], cosine);
    sink.add(layout_.axis(joint_), 5, p[5], sine);
  }

  std::vector<std::string> shapeKeys() const override { return {"harmonic"}; }
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    return otherHarmonics(spec(), harmonic_, kHighestHarmonic);
  }
  std::vector<int> mustMove() const override { return {joint_}; }

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

 private:
  int joint_;
  RadialDirections radial_;
  int harmonic_ = 1;
  std::string name_, turn_;
};

}  // namespace

EffectType rotaryEccentricityType() {
  return effectType<RotaryEccentricity>(
      "rotary_eccentricity", {"joint", "harmonic"}, [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        for (const std::string& joint : jointNames(domain, JointKind::kRotary))
          for (int harmonic = 1; harmonic <= 3; ++harmonic)
            specs.push_back(EffectSpec("rotary_eccentricity").set("joint", joint).set("harmonic", harmonic));
        return specs;
      });
}

}  // namespace mm
