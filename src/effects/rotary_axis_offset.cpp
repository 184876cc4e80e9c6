#include "effects/rotary_axis_offset.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/rotary.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class RotaryAxisOffset : public CatalogueEffect {
 public:
  explicit RotaryAxisOffset(SpecReader& read)
      : CatalogueEffect(read, Stage::kJoint),
        joint_(read.joint("joint", JointKind::kRotary)),
        axis_(read.axisOf("direction", "axis of the joint's fixed side")) {
    name_ = read.domain().joints[joint_].name;
    parameters_ = {parameter("offset", kUnitMicrometre, 1e-5, 1e-2)};
  }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.jointTranslation(joint_, axis_), 0, p[0], 1.0);
  }

  std::vector<int> mustMove() const override { return {joint_}; }

  std::string cause() const override {
    return "Location error of the axis of " + name_ + " (ISO 230-7): it is displaced along " +
           axisName(axis_) + " of its seat.";
  }
  std::string remedy() const override {
    return "Shim or shift the seat of " + name_ + ", or enter the offset in the URDF.";
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

EffectType rotaryAxisOffsetType() {
  return effectType<RotaryAxisOffset>("rotary_axis_offset", {"joint", "direction"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const Joint& joint : domain.joints)
      for (int k = 0; k < 3; ++k)
        if (joint.kind == JointKind::kRotary && !alongAxis(joint, k))
          specs.push_back(
              EffectSpec("rotary_axis_offset").set("joint", joint.name).set("direction", axisName(k)));
    return specs;
  });
}

}  // namespace mm
