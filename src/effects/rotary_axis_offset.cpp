#include "effects/rotary_axis_offset.h"

#include "effects/quantity.h"
#include "effects/rotary.h"
#include "effects/tilt.h"

namespace mm {
namespace {

class RotaryAxisOffset : public RotaryAxisError {
 public:
  explicit RotaryAxisOffset(SpecReader& read) : RotaryAxisError(read, "direction") {
    parameters_ = {parameter("offset", kUnitMicrometre, 1e-5, 1e-2)};
  }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State&, const double* p, ErrorSink& sink) const override {
    sink.add(layout_.jointTranslation(joint_, axis_), 0, p[0], 1.0);
  }

  std::string cause() const override {
    return "Location error of the axis of " + name_ + " (ISO 230-7): it is displaced along " +
           axisName(axis_) + " of its seat.";
  }
  std::string remedy() const override {
    return "Shim or shift the seat of " + name_ + ", or enter the offset in the URDF.";
  }
};

}  // namespace

EffectType rotaryAxisOffsetType() {
  return effectType<RotaryAxisOffset>("rotary_axis_offset", {"joint", "direction"}, [](const Domain& domain) {
    return acrossRotaryAxes("rotary_axis_offset", "direction", domain);
  });
}

}  // namespace mm
