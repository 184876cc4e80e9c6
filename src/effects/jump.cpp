#include "effects/jump.h"

#include <cstdio>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

constexpr int kTimes = 60;  // of a session at which it may have jumped, where its observations are not known

class Jump : public CatalogueEffect {
 public:
  explicit Jump(SpecReader& read) : Jump(read, read.direction("direction")) {}

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    sink.add(slot_, 0, p[0], state.time >= at_ ? 1.0 : 0.0);
  }

  std::vector<std::string> shapeKeys() const override { return {"at_s"}; }

  std::string cause() const override {
    return "Something moved along " + direction_ +
           " during the session and stayed there: a collision, a slipped clamp or artifact, a scale that "
           "lost "
           "counts, an axis that was homed again.";
  }
  std::string remedy() const override {
    return "Find out what happened at that time (the log of the controller), fasten it, home again, and "
           "measure "
           "the session again; a correction of what is over is of no use.";
  }
  std::string shownBy() const override {
    return "The same positions measured repeatedly over the whole session, in changing order.";
  }

 private:
  Jump(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        at_(read.number("at_s", 0.0, 1e9)),
        direction_(direction.name) {
    parameters_ = {errorParameter("step", direction.quantity)};
  }

  int slot_;
  double at_;  // s
  std::string direction_;
};

}  // namespace

EffectType jumpType() {
  return effectType<Jump>("jump", {"direction", "at_s"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    if (!(domain.duration > 0.0)) return specs;
    std::vector<double> times = domain.gaps;
    for (int k = 1; k < kTimes && domain.gaps.empty(); ++k) times.push_back(domain.duration * k / kTimes);
    for (const std::string& direction : directionNames(domain))
      for (const double time : times) {
        char text[32];
        std::snprintf(text, sizeof text, "%.6g", time);
        specs.push_back(EffectSpec("jump").set("direction", direction).set("at_s", std::string(text)));
      }
    return specs;
  });
}

}  // namespace mm
