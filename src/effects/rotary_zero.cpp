#include "effects/rotary_zero.h"

#include "effects/quantity.h"
#include "effects/rotary.h"

namespace mm {
namespace {

class RotaryZero : public RotaryEffect {
 public:
  explicit RotaryZero(SpecReader& read) : RotaryEffect(read, Stage::kAxis) {
    parameters_ = {errorParameter("zero", JointKind::kRotary)};
  }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(joint_), 0, p[0], 1.0);
  }

  std::string cause() const override {
    return "Zero position error of " + name_ +
           ": its home switch or index mark is not where the kinematic chain says.";
  }
  std::string remedy() const override {
    return "Set the zero of " + name_ + " again with an indicator or an autocollimator.";
  }
  std::string shownBy() const override {
    return "Postures with at least two other joints turned, so that the zero of " + name_ +
           " is not equivalent to a rotation of the artifact.";
  }
};

}  // namespace

EffectType rotaryZeroType() {
  return effectType<RotaryZero>("rotary_zero", {"joint"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain, JointKind::kRotary))
      specs.push_back(EffectSpec("rotary_zero").set("joint", joint));
    return specs;
  });
}

}  // namespace mm
