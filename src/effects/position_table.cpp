#include "effects/position_table.h"

#include "effects/catalogue_effect.h"
#include "effects/knots.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class PositionTable : public CatalogueEffect {
 public:
  explicit PositionTable(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Domain& domain = read.domain();
    const Joint& joint = domain.joints[axis_];
    name_ = joint.name;
    std::vector<double> positions;
    if (axis_ < static_cast<int>(domain.positions.size())) positions = domain.positions[axis_];
    if (positions.size() < 2)
      read.fail("a table needs 2 to 64 distinct measured positions of " + name_ + ", and there are " +
                (positions.empty() ? std::string("more (or none); use positioning_polynomial")
                                   : std::string("fewer")));
    knots_ = Knots(positions, joint.kind);
    for (const std::string& name : knots_.names()) parameters_.push_back(errorParameter(name, joint.kind));
  }

  bool composite() const override { return true; }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int slot = layout_.axis(axis_);
    knots_.at(state.position[axis_], [&](int knot, double share) { sink.add(slot, knot, p[knot], share); });
  }

  std::vector<int> mustMove() const override { return {axis_}; }

  std::string cause() const override {
    return "Positioning error of " + name_ + " of any shape: screw, scale, guideway and Abbe error together.";
  }
  std::string remedy() const override {
    return "Load the table into the controller as its pitch error compensation, or leave the correction on.";
  }
  std::string shownBy() const override {
    return "The same target positions of " + name_ +
           " measured several times, by an interferometer or a step gauge.";
  }

 private:
  int axis_;
  std::string name_;
  Knots knots_;
};

}  // namespace

EffectType positionTableType() {
  return effectType<PositionTable>("position_table", {"axis"}, nullptr, true);
}

}  // namespace mm
