#include "effects/straightness.h"

#include "base/legendre.h"
#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class Straightness : public CatalogueEffect {
 public:
  explicit Straightness(SpecReader& read)
      : Straightness(read, read.joint("axis"), read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(slot_, 0, p[0], legendre(degree_, scaled_(state)));
  }

  std::vector<std::string> shapeKeys() const override { return {"degree"}; }
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    return otherValues(spec(), "degree", degree_, 2, 5);
  }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "The guideway of " + name_ + " is not straight: its slide deviates along " + direction_ +
           " as it travels.";
  }
  std::string remedy() const override {
    return "Check the guideway of " + name_ +
           " for wear, dirt and the flatness of its seat; or leave the correction on.";
  }
  std::string shownBy() const override {
    return "Contacts along " + direction_ + " at six positions or more over the travel of " + name_ + ".";
  }

 private:
  Straightness(SpecReader& read, int axis, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        axis_(axis),
        scaled_(read.domain(), axis),
        name_(read.domain().joints[axis].name),
        direction_(direction.name) {
    if (direction.kind == Direction::Kind::kJoint && direction.index == axis)
      read.fail("axis and direction must differ; along the axis itself use positioning_polynomial");
    degree_ = read.integer("degree", 2, 5);
    parameters_ = {errorParameter("amplitude", direction.quantity)};
  }

  int slot_, axis_, degree_ = 2;
  ScaledPosition scaled_;
  std::string name_, direction_;
};

}  // namespace

EffectType straightnessType() {
  return effectType<Straightness>("straightness", {"axis", "direction", "degree"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const auto& [axis, direction] : coupledJoints(domain))
      for (int degree = 2; degree <= 5; ++degree)
        specs.push_back(
            EffectSpec("straightness").set("axis", axis).set("direction", direction).set("degree", degree));
    return specs;
  });
}

}  // namespace mm
