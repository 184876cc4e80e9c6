#include "effects/artifact_expansion.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class ArtifactExpansion : public CatalogueEffect {
 public:
  explicit ArtifactExpansion(SpecReader& read)
      : CatalogueEffect(read, Stage::kArtifact), sensor_(read.sensor("sensor")) {
    name_ = read.domain().sensors[sensor_];
    parameters_ = {expansionParameter(kUnitMicrometre / kUnitMetre / kUnitKelvin)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (state.feature < 0) return;
    const double warmer = state.temperature[sensor_] - kReferenceTemperature;
    for (int k = 0; k < 3; ++k) sink.add(layout_.feature(k), 0, p[0], warmer * state.featurePosition[k]);
    sink.add(layout_.distance(), 0, p[0], warmer * state.featureRadius);
  }

  std::string cause() const override {
    return "The artifact expands with the temperature " + name_ +
           "; the dimensions of its certificate hold at 20 degC.";
  }
  std::string remedy() const override {
    return "Let the artifact reach the temperature of the room, state its coefficient of thermal expansion "
           "in the artifact file, or use one of low expansion.";
  }
  std::string shownBy() const override {
    return "The whole artifact measured at different temperatures of " + name_ + ".";
  }

 private:
  int sensor_;
  std::string name_;
};

}  // namespace

EffectType artifactExpansionType() {
  return effectType<ArtifactExpansion>("artifact_expansion", {"sensor"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (domain.features.empty()) return specs;
    for (const std::string& sensor : domain.sensors)
      specs.push_back(EffectSpec("artifact_expansion").set("sensor", sensor));
    return specs;
  });
}

}  // namespace mm
