#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"
#include "effects/touch.h"

namespace mm {
namespace {

constexpr int kOrders[] = {0, 2, 3, 4, 6};  // that may be asked
constexpr int kHighestOrder = 9;
constexpr double kOtherLobes = 0.1;  // of the lobes that its seat's contacts make
constexpr double kHarmonic = 0.3;    // of the same: a seat on three points has 3, 6, 9 … lobes

class ProbeLobing : public CatalogueEffect {
 public:
  explicit ProbeLobing(SpecReader& read) : CatalogueEffect(read, Stage::kProbe) {
    order_ = read.integer("order", 0, kHighestOrder);
    if (order_ == 1)
      read.fail("order 1 would move the tip, and the artifact's pose takes that up: 0 or 2 to 9");
    variant_ = order_ == 0 ? "sideways" : order_ == 3 ? "on three points" : "";
    if (order_ > 0) parameters_ = {errorParameter("S", JointKind::kLinear)};
    parameters_.push_back(errorParameter("K", JointKind::kLinear));
    // sideways pre-travel is a cause of its own: a stylus that bends, not a seat on some points
    if (order_ > 0) nature_.shapeKeys = {"order"};
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const Touch touch = touchOf(state);
    if (touch == Touch::kNone) return;
    const Eigen::Vector3d& a = state.approach;
    const double across = a.dot(state.orientation.col(0)), along = a.dot(state.orientation.col(1));
    const double phi = std::atan2(along, across), elevation = std::hypot(across, along);  // cos(eps)
    const double sine = elevation * std::sin(order_ * phi), cosine = elevation * std::cos(order_ * phi);
    for (int k = 0; k < 3; ++k) {
      const double component = touch == Touch::kKnown ? a[k] : kUnknown;
      const int last = order_ > 0 ? 1 : 0;
      if (order_ > 0) sink.add(layout_.volume(k), 0, p[0], component * sine);
      sink.add(layout_.volume(k), last, p[last], component * cosine);
    }
  }

  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    std::vector<ShapeFreedom> others;
    if (order_ == 0) return others;
    for (int order = 2; order <= kHighestOrder; ++order)
      if (order != order_ && (order % order_ == 0 || order <= 4))
        others.push_back(
            {EffectSpec(spec()).set("order", order), order % order_ == 0 ? kHarmonic : kOtherLobes});
    return others;
  }

 private:
  int order_ = 3;
};

}  // namespace

EffectType probeLobingType() {
  return effectType<ProbeLobing>("probe_lobing", {"order"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (domain.laser || ballNames(domain).empty()) return specs;
    for (const int order : kOrders) specs.push_back(EffectSpec("probe_lobing").set("order", order));
    return specs;
  });
}

}  // namespace mm
