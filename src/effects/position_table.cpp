#include "effects/position_table.h"

#include <algorithm>
#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class PositionTable : public CatalogueEffect {
 public:
  explicit PositionTable(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Domain& domain = read.domain();
    const Joint& joint = domain.joints[axis_];
    name_ = joint.name;
    if (axis_ < static_cast<int>(domain.positions.size())) positions_ = domain.positions[axis_];
    if (positions_.size() < 2)
      read.fail("a table needs 2 to 64 distinct measured positions of " + name_ + ", and there are " +
                (positions_.empty() ? std::string("more (or none); use positioning_polynomial")
                                    : std::string("fewer")));
    const bool linear = joint.kind == JointKind::kLinear;
    for (const double position : positions_) {
      EffectSpec text;
      text.set("at", 1e-4 * std::round(1e4 * position / (linear ? kMillimetre : kDegree)));
      parameters_.push_back(errorParameter("at_" + text.text("at") + (linear ? "mm" : "deg"), joint.kind));
    }
    for (std::size_t i = 1; i < parameters_.size(); ++i)
      if (parameters_[i].name == parameters_[i - 1].name) parameters_[i].name += "_" + std::to_string(i);
  }

  bool composite() const override { return true; }

  bool choosesFrame(int) const override { return true; }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int slot = layout_.axis(axis_);
    const double q = state.position[axis_];
    const auto after = std::upper_bound(positions_.begin(), positions_.end(), q);
    const int i = static_cast<int>(after - positions_.begin());
    const int last = static_cast<int>(positions_.size()) - 1;
    if (i == 0) return sink.add(slot, 0, p[0], 1.0);
    if (i > last) return sink.add(slot, last, p[last], 1.0);
    const double share = (q - positions_[i - 1]) / (positions_[i] - positions_[i - 1]);
    sink.add(slot, i - 1, p[i - 1], 1.0 - share);
    sink.add(slot, i, p[i], share);
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
  std::vector<double> positions_;  // m or rad, ascending
};

}  // namespace

EffectType positionTableType() {
  return effectType<PositionTable>("position_table", {"axis"}, nullptr, true);
}

}  // namespace mm
