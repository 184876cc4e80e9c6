#include "effects/catalogue_effect.h"
#include "effects/knots.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

class PositionTable : public CatalogueEffect {
 public:
  explicit PositionTable(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Domain& domain = read.domain();
    const Joint& joint = domain.joints[axis_];
    std::vector<double> positions;
    if (axis_ < static_cast<int>(domain.positions.size())) positions = domain.positions[axis_];
    if (positions.size() < 2)
      read.fail("a table needs 2 to 64 distinct measured positions of " + joint.name + ", and there are " +
                (positions.empty() ? std::string("more (or none); use positioning_polynomial")
                                   : std::string("fewer")));
    knots_ = Knots(positions, joint.kind);
    for (const std::string& name : knots_.names()) {
      nature_.choosesFrame.push_back(parameterCount());
      parameters_.push_back(errorParameter(name, joint.kind));
    }
    nature_.composite = true;
    nature_.mustMove = {axis_};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int slot = layout_.axis(axis_);
    knots_.at(state.position[axis_], [&](int knot, double share) { sink.add(slot, knot, p[knot], share); });
  }

 private:
  int axis_;
  Knots knots_;
};

}  // namespace

EffectType positionTableType() {
  return effectType<PositionTable>(
      "position_table", {"axis"}, nullptr, true,
      {EffectSpec("position_table").set("axis", "x"), EffectSpec("position_table").set("axis", "b")});
}

}  // namespace mm
