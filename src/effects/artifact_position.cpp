#include "effects/artifact_position.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class ArtifactPosition : public CatalogueEffect {
 public:
  explicit ArtifactPosition(SpecReader& read)
      : CatalogueEffect(read, Stage::kArtifact), feature_(read.feature("feature")) {
    name_ = read.domain().features[feature_];
    for (int k = 0; k < 3; ++k) parameters_.push_back(parameter(axisName(k), kUnitMicrometre, 1e-6, 1e-2));
  }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (state.feature != feature_) return;
    for (int k = 0; k < 3; ++k) sink.add(layout_.feature(k), k, p[k], 1.0);
  }

  std::string cause() const override {
    return "The feature " + name_ +
           " is not where the artifact file says: it has moved, or its calibrated position is wrong.";
  }
  std::string remedy() const override {
    return "Check that " + name_ +
           " is firmly seated, then have the artifact calibrated again, or declare its position free.";
  }
  std::string shownBy() const override {
    return "Contacts all around " + name_ + " and around at least three other features.";
  }

 private:
  int feature_;
  std::string name_;
};

}  // namespace

EffectType artifactPositionType() {
  return effectType<ArtifactPosition>("artifact_position", {"feature"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& feature : domain.features)
      specs.push_back(EffectSpec("artifact_position").set("feature", feature));
    return specs;
  });
}

}  // namespace mm
