#include "effects/covariate_scale.h"

#include "effects/catalogue_effect.h"
#include "effects/covariate.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class CovariateScale : public CatalogueEffect {
 public:
  explicit CovariateScale(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis),
        axis_(read.joint("axis")),
        covariate_(read.covariate("covariate")),
        reference_(covariateReference(read.domain(), covariate_)) {
    const Joint& joint = read.domain().joints[axis_];
    name_ = read.domain().covariates[covariate_];
    axisName_ = joint.name;
    const double range = covariateRange(read.domain(), covariate_);
    const Unit unit = errorUnit(joint.kind) / readingUnit(joint.kind) / Unit{"unit", 1.0};
    parameters_ = {parameter("slope", unit, 1e-4 / range, 0.02 / range)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.axis(axis_), 0, p[0],
             state.position[axis_] * (state.covariate[covariate_] - reference_));
  }

  /// Neither does a covariate act evenly along the scale: a load bends where it stands.
  std::vector<int> variesAlong(const Domain&) const override { return {axis_}; }
  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "The scale factor of " + axisName_ + " changes with " + name_ +
           " (humidity or load that acts on the scale, pressure that changes the wavelength of an "
           "interferometer).";
  }
  std::string remedy() const override {
    return "Keep " + name_ + " steady, use a scale that does not depend on it, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "Lengths along " + axisName_ + " measured at different values of " + name_ + ".";
  }

 private:
  int axis_, covariate_;
  double reference_;
  std::string name_, axisName_;
};

}  // namespace

EffectType covariateScaleType() {
  return effectType<CovariateScale>("covariate_scale", {"axis", "covariate"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain))
      for (const std::string& covariate : domain.covariates)
        specs.push_back(EffectSpec("covariate_scale").set("axis", joint).set("covariate", covariate));
    return specs;
  });
}

}  // namespace mm
