#include "effects/catalogue_effect.h"
#include "effects/knots.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

constexpr int kFewest = 3;  // the two ends, and one between them

class StraightnessTable : public CatalogueEffect {
 public:
  explicit StraightnessTable(SpecReader& read)
      : StraightnessTable(read, read.joint("axis"), read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int last = knots_.count() - 1;
    knots_.at(state.position[axis_], [&](int knot, double share) {
      if (knot > 0 && knot < last) sink.add(slot_, knot - 1, p[knot - 1], share);
    });
  }

 private:
  StraightnessTable(SpecReader& read, int axis, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        axis_(axis),
        knots_(positionsOf(read, axis), read.domain().joints[axis].kind) {
    if (direction.kind == Direction::Kind::kJoint && direction.index == axis)
      read.fail("axis and direction must differ; along the axis itself use position_table");
    const std::vector<std::string> names = knots_.names();
    for (int knot = 1; knot + 1 < knots_.count(); ++knot)
      parameters_.push_back(errorParameter(names[knot], direction.quantity));
    nature_.composite = true;
    nature_.shapeKeys = {"knots"};
    nature_.mustMove = {axis_};
    nature_.positionsNeeded = knots_.count();
  }

  /// The measured positions, or as many as asked for, evenly over the travel that the session covered.
  static std::vector<double> positionsOf(SpecReader& read, int axis) {
    const Domain& domain = read.domain();
    const auto j = static_cast<std::size_t>(axis);
    const int count = read.integer("knots", kFewest, Knots::kMost, 0);
    if (count == 0) {
      if (j < domain.positions.size() && domain.positions[j].size() >= kFewest) return domain.positions[j];
      const bool none = j >= domain.positions.size() || domain.positions[j].empty();
      read.fail("without 'knots' a table needs 3 to 64 distinct measured positions of " +
                domain.joints[j].name + ", and there are " +
                (none ? "more (or none); add for example knots: 9" : "fewer"));
    }
    const double range = observedRange(domain, axis);
    if (!(range > 0.0)) read.fail(domain.joints[j].name + " never moved; measure over its travel");
    std::vector<double> positions;
    for (int i = 0; i < count; ++i) positions.push_back(domain.lower[j] + range * i / (count - 1));
    return positions;
  }

  int slot_, axis_;
  Knots knots_;
};

}  // namespace

EffectType straightnessTableType() {
  return effectType<StraightnessTable>(
      "straightness_table", {"axis", "direction", "knots"}, nullptr, true,
      {EffectSpec("straightness_table").set("axis", "x").set("direction", "y"),
       EffectSpec("straightness_table").set("axis", "a").set("direction", "b")});
}

}  // namespace mm
