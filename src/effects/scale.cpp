#include "effects/scale.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class Scale : public CatalogueEffect {
 public:
  explicit Scale(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Joint& joint = read.domain().joints[axis_];
    name_ = joint.name;
    parameters_ = {slopeParameter("scale", joint.kind, joint.kind)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(axis_), 0, p[0], state.position[axis_]);
  }

  /// A lead that is wrong is rarely wrong by the same everywhere.
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    const EffectSpec further = EffectSpec("positioning_polynomial").set("axis", name_);
    return {{EffectSpec(further).set("degree", 2)}, {EffectSpec(further).set("degree", 3)}};
  }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "The scale factor or the mean screw lead of " + name_ +
           " is wrong: its error is proportional to the reading.";
  }
  std::string remedy() const override {
    return "Correct the counts per unit of " + name_ +
           " in the controller, against a length standard at 20 degC.";
  }
  std::string shownBy() const override {
    return "Known lengths along " + name_ +
           " over most of its travel: two balls at a calibrated distance, or an interferometer.";
  }

 private:
  int axis_;
  std::string name_;
};

}  // namespace

EffectType scaleType() {
  return effectType<Scale>("scale", {"axis"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain))
      specs.push_back(EffectSpec("scale").set("axis", joint));
    return specs;
  });
}

}  // namespace mm
