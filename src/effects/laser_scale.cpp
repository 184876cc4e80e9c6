#include "effects/laser_scale.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class LaserScale : public CatalogueEffect {
 public:
  explicit LaserScale(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    if (!read.domain().laser) read.fail("the session has no readings of a laser probe (reading_mm)");
    parameters_ = {parameter("scale", kUnitMicrometre / kUnitMetre, 1e-3, 0.2)};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.reading(), 0, p[0], state.laserReading);
  }

  std::string cause() const override {
    return "The laser probe's reading is out of scale: gain of its sensor or of its electronics.";
  }
  std::string remedy() const override {
    return "Calibrate the laser probe against a known displacement along its beam.";
  }
  std::string shownBy() const override {
    return "The same surface seen at readings from both ends of the laser's range.";
  }
};

}  // namespace

EffectType laserScaleType() {
  return effectType<LaserScale>("laser_scale", {}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (domain.laser) specs.emplace_back("laser_scale");
    return specs;
  });
}

}  // namespace mm
