#include "effects/thermal_bending.h"

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class ThermalBending : public CatalogueEffect {
 public:
  explicit ThermalBending(SpecReader& read) : CatalogueEffect(read, Stage::kVolume) {
    name_ = read.domain().joints[read.joint("axis")].name;
    about_ = read.axisOf("about");
    sensors_ = read.sensorPair("sensors");
    parameters_ = {parameter("bending", kUnitArcsecond / kUnitKelvin, kArcsecond, 1e-3)};
    pair_ = read.domain().sensors[sensors_.first] + " and " + read.domain().sensors[sensors_.second];
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    addTilt(layout_, about_, state, 0, p[0],
            state.temperature[sensors_.first] - state.temperature[sensors_.second], sink);
  }

  std::string cause() const override {
    return "The member that carries " + name_ + " is warmer on one side: it bends and tilts about " +
           axisName(about_) + " in proportion to the temperature difference of " + pair_ + ".";
  }
  std::string remedy() const override {
    return "Bring both sides to one temperature (insulate, move the heat source, circulate the air), or "
           "leave the correction on.";
  }
  std::string shownBy() const override {
    return "Contacts at different Abbe offsets (distances from the axis " + axisName(about_) +
           ") while the difference of " + pair_ + " changes.";
  }

 private:
  int about_ = 0;
  std::pair<int, int> sensors_;
  std::string name_, pair_;
};

}  // namespace

EffectType thermalBendingType() {
  return effectType<ThermalBending>(
      "thermal_bending", {"axis", "about", "sensors"}, [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        if (domain.joints.empty()) return specs;
        // Which member bends does not change the displacement: one is offered, the column that carries z
        // where there is one.
        const std::string axis = domain.findJoint("z") >= 0 ? "z" : domain.joints.front().name;
        for (int about = 0; about < 3; ++about)
          for (std::size_t a = 0; a < domain.sensors.size(); ++a)
            for (std::size_t b = a + 1; b < domain.sensors.size(); ++b)
              specs.push_back(EffectSpec("thermal_bending")
                                  .set("axis", axis)
                                  .set("about", axisName(about))
                                  .setList("sensors", {domain.sensors[a], domain.sensors[b]}));
        return specs;
      });
}

}  // namespace mm
