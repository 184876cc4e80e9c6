#include "effects/squareness.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class Squareness : public CatalogueEffect {
 public:
  explicit Squareness(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")), of_(read.joint("of")) {
    if (axis_ == of_) read.fail("axis and of must be different joints; for an axis on itself use scale");
    const auto& joints = read.domain().joints;
    axisName_ = joints[axis_].name;
    ofName_ = joints[of_].name;
    parameters_ = {slopeParameter("slope", joints[axis_].kind, joints[of_].kind)};
  }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(axis_), 0, p[0], state.position[of_]);
  }

  std::vector<int> mustMove() const override { return {of_}; }

  std::string cause() const override {
    return "The guideway of " + ofName_ + " is not square to " + axisName_ + ": travel of " + ofName_ +
           " displaces the probe along " + axisName_ + " in proportion.";
  }
  std::string remedy() const override {
    return "Square the guideway of " + ofName_ + " to " + axisName_ +
           " with a square and an indicator, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "Contacts spread over the plane of " + axisName_ + " and " + ofName_ +
           ": balls at its corners, or one artifact in two orientations.";
  }

 private:
  int axis_, of_;
  std::string axisName_, ofName_;
};

}  // namespace

EffectType squarenessType() {
  return effectType<Squareness>("squareness", {"axis", "of"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const auto& [axis, of] : coupledJoints(domain))
      specs.push_back(EffectSpec("squareness").set("axis", axis).set("of", of));
    return specs;
  });
}

}  // namespace mm
