// What changes with time alone.
#include <algorithm>
#include <cmath>

#include "base/format.h"
#include "effects/law.h"
#include "effects/quantity.h"
#include "effects/time_constant.h"

namespace mm {
namespace {

double durationOf(const SpecReader& read) { return std::max(read.domain().duration, 1.0); }

Law timeDrift(SpecReader& read) {
  const Direction direction = read.direction("direction");
  const Parameter whole = errorParameter("rate", direction.quantity);
  return oneTerm(stageOf(direction), direction.slot(read.layout()),
                 parameter("rate", errorUnit(direction.quantity) / kUnitHour, whole.scale / durationOf(read),
                           whole.bound / durationOf(read)),
                 [](const State& s) { return s.time; });
}

Law jump(SpecReader& read) {
  const Direction direction = read.direction("direction");
  const double at = read.number("at_s", 0.0, 1e9);
  Law law = oneTerm(stageOf(direction), direction.slot(read.layout()),
                    errorParameter("step", direction.quantity), [at](const State& s) {
                      return std::isnan(s.time) ? kUnknown : s.time >= at ? 1.0 : 0.0;
                    });
  law.nature.shapeKeys = {"at_s"};
  return law;
}

/// Moments between the observations; where these are not known, moments of the session.
std::vector<std::string> momentsOf(const Domain& domain) {
  constexpr int kTimes = 60;
  std::vector<std::string> moments;
  if (!(domain.duration > 0.0)) return moments;
  // what differs in one reading alone is an outlier
  for (std::size_t k = 1; k + 1 < domain.gaps.size(); ++k) moments.push_back(format("%.6g", domain.gaps[k]));
  for (int k = 1; k < kTimes && domain.gaps.empty(); ++k)
    moments.push_back(format("%.6g", domain.duration * k / kTimes));
  return moments;
}

/// 1 - exp(-t / tau) by its limit where tau is short, of a first parameter of this sign.
std::function<void(const State&, const double*, ErrorSink&)> saturation(int slot, double sign) {
  return [slot, sign](const State& s, const double* p, ErrorSink& sink) {
    const double tau = p[1], t = s.time;
    if (tau <= 0.0) return sink.add(slot, 0, p[0], t > 0.0 ? sign : 0.0);
    sink.add(slot, 0, p[0], -sign * std::expm1(-t / tau));
    if (sink.wantsDerivatives())
      sink.derivative(slot, 1, -sign * p[0] * std::exp(-t / tau) * t / (tau * tau));
  };
}

Law warmUp(SpecReader& read) {
  const Direction direction = read.direction("direction");
  Law law;
  law.nature.stage = stageOf(direction);
  law.parameters = {errorParameter("amplitude", direction.quantity)};
  settles(law, read.domain());
  law.add = saturation(direction.slot(read.layout()), 1.0);
  // a machine has more than one time constant: behind the quick one it still creeps
  law.freedom = {{EffectSpec("time_drift").set("direction", direction.name)}};
  return law;
}

/// A screw that its own running warms: a strain that saturates, and what it moves at the zero of the
/// readings, since nobody knows where the screw is held.
Law scaleWarmUp(SpecReader& read) {
  const int axis = read.joint("axis");
  const JointKind kind = read.jointAt(axis).kind;
  const int slot = read.layout().axis(axis);
  Parameter strain = parameter("strain", errorUnit(kind) / readingUnit(kind), 1e-5, 1e-3);
  // screws run 5 to 10 K above the machine (ISO 230-3), and steel has 11.5e-6/K
  strain.usual = 1.2e-4;
  Law law;
  law.nature.stage = Stage::kAxis;
  law.nature.met = 0.3;  // an axis that measures moves slowly, and its screw seldom warms
  law.nature.mustMove = {axis};
  law.parameters = {strain, errorParameter("offset", kind)};
  settles(law, read.domain());
  law.add = [axis, slot](const State& s, const double* p, ErrorSink& sink) {
    const double tau = p[2], t = s.time, q = s.position[axis];
    const double reached = tau > 0.0 ? -std::expm1(-t / tau) : t > 0.0 ? 1.0 : 0.0 * t;
    sink.add(slot, 0, p[0], q * reached);
    sink.add(slot, 1, p[1], reached);
    if (sink.wantsDerivatives())
      sink.derivative(slot, 2, tau > 0.0 ? -(p[0] * q + p[1]) * std::exp(-t / tau) * t / (tau * tau) : 0.0);
  };
  return law;
}

Law timeCycle(SpecReader& read) {
  constexpr double kFewest = 2.0, kMost = 40.0;  // cycles in a session
  constexpr double kStep = 0.5;  // between two starts: the search refines by a quarter of a cycle
  const Direction direction = read.direction("direction");
  const int slot = direction.slot(read.layout());
  const double duration = durationOf(read);
  Parameter period = parameter("period", {"s", 1.0}, 0.02 * duration, 10.0 * duration, 0.1 * duration);
  period.minimum = 0.5 * duration / kMost;
  period.maximum = 10.0 * duration;
  Law law;
  law.nature.stage = stageOf(direction);
  law.parameters = {errorParameter("S", direction.quantity), errorParameter("K", direction.quantity), period};
  law.add = [slot](const State& s, const double* p, ErrorSink& sink) {
    const double phase = 2.0 * kPi * s.time / p[2];
    const double sine = std::sin(phase), cosine = std::cos(phase);
    sink.add(slot, 0, p[0], sine);
    sink.add(slot, 1, p[1], cosine);
    if (sink.wantsDerivatives()) sink.derivative(slot, 2, -(p[0] * cosine - p[1] * sine) * phase / p[2]);
  };
  for (double cycles = kFewest; cycles <= kMost; cycles += kStep) law.starts.push_back(duration / cycles);
  law.longest = duration / kFewest;  // of fewer cycles the session does not show that they come again
  law.beside = {{0.5, 0.15}};        // what is switched on and off is no pure sine
  return law;
}

/// The session says how long it lasted, and the probe touches balls.
bool wears(const EffectSpec&, const Domain& domain) {
  return !domain.laser && domain.duration > 0.0 && !ballNames(domain).empty();
}

Law tipWear(SpecReader& read) {
  const int slot = read.layout().distance();
  const bool slows = read.flag("slows", false);
  const Parameter whole = errorParameter(slows ? "depth" : "rate", JointKind::kLinear);
  Law law = oneTerm(Stage::kProbe, slot,
                    parameter("rate", errorUnit(JointKind::kLinear) / kUnitHour,
                              whole.scale / durationOf(read), whole.bound / durationOf(read)),
                    [](const State& s) { return -s.time; });
  law.nature.shapeKeys = {"slows"};
  if (slows) {
    law.parameters = {whole};
    settles(law, read.domain());
    law.add = saturation(slot, -1.0);
    law.freedom = {{EffectSpec("tip_wear")}};  // the quick wear of a new tip leaves the steady one
    law.variant = "that slows down";
  }
  law.parameters[0].seldomNegative = true;  // a tip that picks something up
  return law;
}

}  // namespace

std::vector<LawRow> lawsOfTime() {
  return {
      {"time_drift", {"direction"}, {directions()}, {}, timeDrift},
      {"jump", {"direction", "at_s"}, {directions(), named("at_s", momentsOf)}, {}, jump},
      {"warm_up", {"direction"}, {directions()}, {}, warmUp},
      {"scale_warm_up", {"axis"}, {joints("axis", JointKind::kLinear)}, {}, scaleWarmUp},
      {"time_cycle", {"direction"}, {directions()}, {}, timeCycle},
      {"tip_wear", {"slows"}, {fixed("slows", {"", "true"})}, wears, tipWear},
  };
}

}  // namespace mm
