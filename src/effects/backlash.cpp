#include "effects/backlash.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class Backlash : public CatalogueEffect {
 public:
  explicit Backlash(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Joint& joint = read.domain().joints[axis_];
    name_ = joint.name;
    parameters_ = {errorParameter("gap", joint.kind)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double travel = state.travel[axis_];
    sink.add(layout_.axis(axis_), 0, p[0], travel == 0.0 ? kUnknown : -0.5 * travel);
  }

  /// A nut wears most where it works most: the play changes along the screw.
  std::vector<int> variesAlong(const Domain&) const override { return {axis_}; }

  std::string cause() const override {
    return "Play in the drive of " + name_ +
           " (nut, gear, thrust bearing, belt): the slide stops short in the direction of travel, so the two "
           "directions differ by the gap (reversal value, ISO 230-2). A negative gap is no play: the "
           "backlash compensation of the controller is larger than the play.";
  }
  std::string remedy() const override {
    return "Preload or replace the nut, the thrust bearing or the gear of " + name_ +
           "; until then approach every point from the same side. Where the gap is negative, lower the "
           "backlash compensation of the controller by its magnitude.";
  }
  std::string shownBy() const override {
    return "The same positions reached in both directions of " + name_ +
           ", with the direction of travel recorded.";
  }

 private:
  int axis_;
  std::string name_;
};

}  // namespace

EffectType backlashType() {
  return effectType<Backlash>("backlash", {"axis"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain))
      specs.push_back(EffectSpec("backlash").set("axis", joint));
    return specs;
  });
}

}  // namespace mm
