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
    return "The sensitivity of the laser probe is not the stated one: the error of its reading is "
           "proportional to the reading.";
  }
  std::string remedy() const override {
    return "Calibrate the laser probe against a known displacement along its beam.";
  }
  std::string shownBy() const override {
    return "The same surface measured at readings from both ends of the range of the laser.";
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
