#include "effects/gravity_sag.h"

#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class GravitySag : public CatalogueEffect {
 public:
  explicit GravitySag(SpecReader& read) : GravitySag(read, read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double extension = state.position[with_] - lower_;
    sink.add(slot_, 0, p[0], power_ == 2 ? extension * extension : extension * extension * extension);
  }

  std::vector<std::string> shapeKeys() const override { return {"power"}; }
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    return otherValues(spec(), "power", power_, 2, 3);
  }
  std::vector<int> mustMove() const override { return {with_}; }

  std::string cause() const override {
    return "The arm or beam that " + name_ +
           " extends deflects under its own weight, more than in proportion to its extension.";
  }
  std::string remedy() const override {
    return "Stiffen or counterweight the arm, measure with less extension of " + name_ +
           ", or leave the correction on.";
  }
  std::string shownBy() const override {
    return "Heights measured at the same positions of the other axes over the whole extension of " + name_ +
           ".";
  }

 private:
  GravitySag(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        with_(read.joint("with", JointKind::kLinear)) {
    if (direction.quantity != JointKind::kLinear)
      read.fail("direction must be the vertical, not a rotary joint");
    power_ = read.integer("power", 2, 3);
    name_ = read.domain().joints[with_].name;
    if (with_ < static_cast<int>(read.domain().lower.size())) lower_ = read.domain().lower[with_];
    const double observed = observedRange(read.domain(), with_);
    const double reach = std::pow(observed > 0.0 ? observed : 0.1, power_);
    parameters_ = {parameter("sag", {"um/m^" + std::to_string(power_), 1e6}, 1e-6 / reach, 1e-3 / reach)};
  }

  int slot_, with_, power_ = 2;
  double lower_ = 0.0;  // m
  std::string name_;
};

}  // namespace

EffectType gravitySagType() {
  return effectType<GravitySag>("gravity_sag", {"direction", "with", "power"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    const int z = domain.findJoint("z");  // the vertical is the joint z, else z of the workpiece
    if (z >= 0 && domain.joints[z].kind != JointKind::kLinear) return specs;
    for (const std::string& joint : jointNames(domain, JointKind::kLinear))
      for (int power = 2; power <= 3; ++power)
        specs.push_back(
            EffectSpec("gravity_sag").set("direction", "z").set("with", joint).set("power", power));
    return specs;
  });
}

}  // namespace mm
