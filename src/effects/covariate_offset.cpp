#include "effects/covariate_offset.h"

#include "effects/catalogue_effect.h"
#include "effects/covariate.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class CovariateOffset : public CatalogueEffect {
 public:
  explicit CovariateOffset(SpecReader& read) : CovariateOffset(read, read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(slot_, 0, p[0], state.covariate[covariate_] - reference_);
  }

  std::string cause() const override {
    return "The position along " + direction_ + " changes with " + name_ + ".";
  }
  std::string remedy() const override {
    return "Keep " + name_ +
           " steady, find how it acts on the machine and separate the two, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "The same positions measured at different values of " + name_ +
           ", not correlated with time or temperature.";
  }

 private:
  CovariateOffset(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        covariate_(read.covariate("covariate")),
        reference_(covariateReference(read.domain(), covariate_)),
        name_(read.domain().covariates[covariate_]),
        direction_(direction.name) {
    const double range = covariateRange(read.domain(), covariate_);
    const Parameter whole = errorParameter("slope", direction.quantity);
    parameters_ = {parameter("slope", errorUnit(direction.quantity) / Unit{"unit", 1.0}, whole.scale / range,
                             whole.bound / range)};
  }

  int slot_, covariate_;
  double reference_;
  std::string name_, direction_;
};

}  // namespace

EffectType covariateOffsetType() {
  return effectType<CovariateOffset>(
      "covariate_offset", {"direction", "covariate"}, [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        for (const std::string& direction : directionNames(domain))
          for (const std::string& covariate : domain.covariates)
            specs.push_back(
                EffectSpec("covariate_offset").set("direction", direction).set("covariate", covariate));
        return specs;
      });
}

}  // namespace mm
