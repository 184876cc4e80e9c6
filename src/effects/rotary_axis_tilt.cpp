#include "effects/rotary_axis_tilt.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/rotary.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class RotaryAxisTilt : public CatalogueEffect {
 public:
  explicit RotaryAxisTilt(SpecReader& read)
      : CatalogueEffect(read, Stage::kJoint),
        joint_(read.joint("joint", JointKind::kRotary)),
        axis_(read.axisOf("about", "axis of the joint's fixed side")) {
    name_ = read.domain().joints[joint_].name;
    parameters_ = {parameter("tilt", kUnitArcsecond, kArcsecond, 0.1)};
  }

  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.jointRotation(joint_, axis_), 0, p[0], 1.0);
  }

  std::vector<int> mustMove() const override { return {joint_}; }

  std::string cause() const override {
    return "Orientation error of the axis of " + name_ + " (ISO 230-7): it is tilted about " +
           axisName(axis_) + " of its seat.";
  }
  std::string remedy() const override {
    return "Shim the seat of " + name_ + " with an indicator on a mandrel, or enter the tilt in the URDF.";
  }
  std::string shownBy() const override {
    return "Postures that turn " + name_ +
           " over most of its range, and the other joints with it, at one ball.";
  }

 private:
  int joint_, axis_;
  std::string name_;
};

}  // namespace

EffectType rotaryAxisTiltType() {
  return effectType<RotaryAxisTilt>("rotary_axis_tilt", {"joint", "about"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const Joint& joint : domain.joints)
      for (int k = 0; k < 3; ++k)
        if (joint.kind == JointKind::kRotary && !alongAxis(joint, k))
          specs.push_back(EffectSpec("rotary_axis_tilt").set("joint", joint.name).set("about", axisName(k)));
    return specs;
  });
}

}  // namespace mm
