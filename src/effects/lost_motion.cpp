#include "effects/lost_motion.h"

#include <algorithm>
#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class LostMotion : public CatalogueEffect {
 public:
  explicit LostMotion(SpecReader& read) : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Joint& joint = read.domain().joints[axis_];
    const bool linear = joint.kind == JointKind::kLinear;
    name_ = joint.name;
    const double observed = observedRange(read.domain(), axis_);
    range_ = observed > 0.0 ? observed : linear ? 10.0 * kMillimetre : 10.0 * kDegree;
    Parameter distance = parameter("distance", linear ? kUnitMillimetre : kUnitDegree, 0.1 * range_,
                                   10.0 * range_, 0.1 * range_);
    distance.minimum = 0.0;
    distance.maximum = 100.0 * range_;
    parameters_ = {errorParameter("gap", joint.kind), errorParameter("at_once", joint.kind), distance};
  }

  bool linear() const override { return false; }
  double met() const override { return 0.3; }  // a play is met more often
  std::vector<int> nonlinearParameters() const override { return {2}; }
  std::vector<std::vector<double>> searchStarts() const override {
    std::vector<std::vector<double>> starts;
    for (int k = kShortest; k <= kLongest; ++k) starts.push_back({std::ldexp(range_, k)});
    return starts;
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double travel = state.travel[axis_], way = state.sinceReversalOf(axis_), distance = p[2];
    const double side = travel == 0.0 ? kUnknown : -0.5 * travel;
    const double left = distance > 0.0 ? std::exp(-way / distance) : way > 0.0 ? 0.0 : 1.0;
    const int slot = layout_.axis(axis_);
    sink.add(slot, 0, p[0], side * (1.0 - left));
    sink.add(slot, 1, p[1], side * left);
    if (!sink.wantsDerivatives()) return;
    const bool changes = distance > 0.0 && left > 0.0;  // infinitely far away nothing does
    sink.derivative(slot, 2,
                    changes ? side * (p[1] - p[0]) * left * way / (distance * distance) : 0.0 * side);
  }

  /// Over less the session saw a play, over more a play and a scale.
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || (nonlinear.front() >= std::ldexp(range_, kShortest - 1) &&
                                 nonlinear.front() <= std::ldexp(range_, kLongest + 1));
  }

  /// No drive winds up by one exponential: some of it sooner, some later.
  std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& nonlinear) const override {
    return {{{0.5 * nonlinear.front()}, kOther}, {{2.0 * nonlinear.front()}, kOther}};
  }

  std::string cause() const override {
    return "After a reversal the drive of " + name_ +
           " winds up (screw, belt, bearing against the friction of the guideway) before the slide follows: "
           "what is lost grows to the gap over the distance. A play is lost at once; where at_once is "
           "negative, the slide at first still is where the old direction had it.";
  }
  std::string remedy() const override {
    return "Lower the friction of the guideway of " + name_ +
           " (lubrication, preload), stiffen its drive, or measure by a scale at the slide; until then "
           "approach every point from the same side and from further away than three distances.";
  }
  std::string shownBy() const override {
    return "Positions of " + name_ +
           " in both directions at small steps behind the reversal, read by an instrument: the way since the "
           "reversal is not known of a touch.";
  }

 private:
  static constexpr int kShortest = -5, kLongest = -1;  // powers of two, of the range
  static constexpr double kOther = 0.4;                // share of what is lost over another distance
  int axis_;
  double range_ = 0.0;  // m or rad
  std::string name_;
};

}  // namespace

EffectType lostMotionType() {
  return effectType<LostMotion>("lost_motion", {"axis"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& joint : jointNames(domain))
      specs.push_back(EffectSpec("lost_motion").set("axis", joint));
    return specs;
  });
}

}  // namespace mm
