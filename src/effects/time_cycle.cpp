#include "effects/time_cycle.h"

#include <algorithm>
#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"

namespace mm {
namespace {

class TimeCycle : public CatalogueEffect {
 public:
  explicit TimeCycle(SpecReader& read) : TimeCycle(read, read.direction("direction")) {}

  bool linear() const override { return false; }
  std::vector<int> nonlinearParameters() const override { return {2}; }
  std::vector<std::vector<double>> searchStarts() const override {
    std::vector<std::vector<double>> starts;
    for (double cycles = kFewest; cycles <= kMost; cycles += kStep) starts.push_back({duration_ / cycles});
    return starts;
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const double phase = 2.0 * kPi * state.time / p[2];
    const double sine = std::sin(phase), cosine = std::cos(phase);
    sink.add(slot_, 0, p[0], sine);
    sink.add(slot_, 1, p[1], cosine);
    if (sink.wantsDerivatives()) sink.derivative(slot_, 2, -(p[0] * cosine - p[1] * sine) * phase / p[2]);
  }

  /// Of fewer cycles the session does not show that they come again.
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    return nonlinear.empty() || nonlinear.front() <= duration_ / kFewest;
  }
  /// What is switched on and off is no pure sine: the second harmonic.
  std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& nonlinear) const override {
    if (nonlinear.empty()) return {};
    return {{{0.5 * nonlinear[0]}, 0.15}};
  }

  std::string cause() const override {
    return "Something that comes again at equal times moves the machine along " + direction_ +
           ": air conditioning, a cooler, a pump or a heater that is switched on and off.";
  }
  std::string remedy() const override {
    return "Find what has this period (the room's temperature, the log of the cooler), screen or steady it, "
           "or "
           "measure one point over several periods and average.";
  }
  std::string shownBy() const override {
    return "One position measured often over several periods, at times that are no multiple of the period.";
  }

 private:
  static constexpr double kFewest = 2.0, kMost = 40.0;  // cycles in a session
  static constexpr double kStep = 0.5;  // between two starts: the search refines by a quarter of a cycle

  TimeCycle(SpecReader& read, const Direction& direction)
      : CatalogueEffect(read, direction),
        slot_(direction.slot(layout_)),
        duration_(std::max(read.domain().duration, 1.0)),
        direction_(direction.name) {
    parameters_ = {errorParameter("S", direction.quantity), errorParameter("K", direction.quantity),
                   parameter("period", {"s", 1.0}, 0.02 * duration_, 10.0 * duration_, 0.1 * duration_)};
    parameters_[2].minimum = 0.5 * duration_ / kMost;
    parameters_[2].maximum = 10.0 * duration_;
  }

  int slot_;
  double duration_;  // s
  std::string direction_;
};

}  // namespace

EffectType timeCycleType() {
  return effectType<TimeCycle>("time_cycle", {"direction"}, [](const Domain& domain) {
    std::vector<EffectSpec> specs;
    for (const std::string& direction : directionNames(domain))
      specs.push_back(EffectSpec("time_cycle").set("direction", direction));
    return specs;
  });
}

}  // namespace mm
