#include "effects/ball_radius.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class BallRadius : public CatalogueEffect {
 public:
  explicit BallRadius(SpecReader& read) : CatalogueEffect(read, Stage::kArtifact), ball_(read.ball("ball")) {
    name_ = read.domain().features[ball_];
    parameters_ = {errorParameter("radius", JointKind::kLinear)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    if (state.feature == ball_) sink.add(layout_.distance(), 0, p[0], 1.0);
  }

  std::string cause() const override {
    return "The ball " + name_ + " is larger or smaller than the artifact file says, or it is dirty.";
  }
  std::string remedy() const override {
    return "Clean the ball " + name_ +
           ", measure its diameter (micrometer, certificate) and correct the artifact file.";
  }
  std::string shownBy() const override {
    return "Contacts from opposite sides on " + name_ + " and on other balls whose radius is known.";
  }

 private:
  int ball_;
  std::string name_;
};

}  // namespace

EffectType ballRadiusType() {
  return effectType<BallRadius>("ball_radius", {"ball"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& ball : ballNames(domain))
      specs.push_back(EffectSpec("ball_radius").set("ball", ball));
    return specs;
  });
}

}  // namespace mm
