#include "effects/rotary_axis_tilt.h"

#include "effects/quantity.h"
#include "effects/rotary.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class RotaryAxisTilt : public RotaryAxisError {
 public:
  explicit RotaryAxisTilt(SpecReader& read) : RotaryAxisError(read, "about") {
    parameters_ = {parameter("tilt", kUnitArcsecond, kArcsecond, 0.1)};
  }

  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.jointRotation(joint_, axis_), 0, p[0], 1.0);
  }

  std::string cause() const override {
    return "Orientation error of the axis of " + name_ + " (ISO 230-7): it is tilted about " +
           axisName(axis_) + " of its seat.";
  }
  std::string remedy() const override {
    return "Shim the seat of " + name_ + " with an indicator on a mandrel, or enter the tilt in the URDF.";
  }
};

}  // namespace

EffectType rotaryAxisTiltType() {
  return effectType<RotaryAxisTilt>("rotary_axis_tilt", {"joint", "about"}, [](const Domain& domain) {
    return acrossRotaryAxes("rotary_axis_tilt", "about", domain);
  });
}

}  // namespace mm
