#include "effects/positioning_polynomial.h"

#include "base/legendre.h"
#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class PositioningPolynomial : public CatalogueEffect {
 public:
  explicit PositioningPolynomial(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")), scaled_(read.domain(), axis_) {
    degree_ = read.integer("degree", 2, 5);
    name_ = read.domain().joints[axis_].name;
    parameters_ = {errorParameter("amplitude", read.domain().joints[axis_].kind)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(axis_), 0, p[0], legendre(degree_, scaled_(state)));
  }

  std::vector<std::string> shapeKeys() const override { return {"degree"}; }
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    std::vector<ShapeFreedom> all = otherValues(spec(), "degree", degree_, 2, 5);
    // a lead that changes is rarely right on average
    all.push_back({EffectSpec("scale").set("axis", name_)});
    return all;
  }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "The lead of " + name_ +
           " changes along its travel: a worn or bowed screw, a stretched belt, a scale under strain.";
  }
  std::string remedy() const override {
    return "Measure " + name_ +
           " with an interferometer and replace the worn part, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "Known positions of " + name_ + " at six places or more over its whole travel.";
  }

 private:
  int axis_, degree_ = 2;
  ScaledPosition scaled_;
  std::string name_;
};

}  // namespace

EffectType positioningPolynomialType() {
  return effectType<PositioningPolynomial>(
      "positioning_polynomial", {"axis", "degree"}, [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        for (const std::string& joint : jointNames(domain))
          for (int degree = 2; degree <= 5; ++degree)
            specs.push_back(EffectSpec("positioning_polynomial").set("axis", joint).set("degree", degree));
        return specs;
      });
}

}  // namespace mm
