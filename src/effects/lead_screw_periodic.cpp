#include <algorithm>
#include <cmath>
#include <cstdio>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

class LeadScrewPeriodic : public CatalogueEffect {
 public:
  explicit LeadScrewPeriodic(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis")) {
    const Joint& joint = read.domain().joints[axis_];
    const bool linear = joint.kind == JointKind::kLinear;
    name_ = joint.name;
    parameters_ = {errorParameter("S", joint.kind), errorParameter("K", joint.kind)};
    const std::string key = linear ? "period_mm" : "period_deg", other = linear ? "period_deg" : "period_mm";
    if (read.has(other)) read.fail("the period of " + name_ + " is given as " + key + ", not " + other);
    const double unit = linear ? kMillimetre : kDegree;
    travel_ = observedRange(read.domain(), axis_);
    spacing_ = read.domain().spacingOf(axis_);
    searched_ = read.isWord(key, "unknown");
    nature_.shapeKeys = {"period_mm", "period_deg"};
    nature_.variesAlong = nature_.mustMove = {axis_};
    // A period that is searched for takes several waves at several places each: nine places are met by many.
    nature_.positionsNeeded = searched_ ? 12 : 5;
    if (!searched_) {
      period_ = read.number(key, 1e-6, 1e6) * unit;
      return;
    }
    nature_.linear = false;
    nature_.nonlinear = {2};
    nature_.fineWaves.joint = axis_;
    std::vector<std::vector<double>>& starts = nature_.searchStarts;
    std::vector<double>& fine = nature_.fineWaves.lengths;
    if (!linear) {  // a wheel has a whole number of teeth, and so has its worm's turn a whole part of a turn
      for (int teeth = kFewestTeeth; teeth <= kMostTeeth; ++teeth)
        if (!isAlias(2.0 * kPi / teeth)) starts.push_back({2.0 * kPi / teeth});
      Parameter period = parameter("period", kUnitDegree, 1e-3, 2.0 * kPi, 2.0 * kPi / 60.0);
      period.minimum = std::max(kPi / kMostTeeth, kNyquist * spacing_);
      period.maximum = 20.0 * kPi;
      parameters_.push_back(period);
      return;
    }
    // Frequencies a third of a cycle over the range apart: from half a cycle to sixty.
    const double range = travel_ > 0.0 ? travel_ : 10.0 * kMillimetre;
    const double shortest = std::max(range / 60.0, 0.05 * kMillimetre);
    double cycles = 0.5;
    for (; cycles <= range / shortest && !isAlias(range / cycles); cycles += kStep)
      starts.push_back({range / cycles});
    const double most = std::min(range / (kFinest * kMillimetre), kMostWaves);
    for (; cycles <= most && !isAlias(range / cycles); cycles += kStep) fine.push_back(range / cycles);
    const double finest = fine.empty() ? starts.back().front() : fine.back();
    Parameter period = parameter("period", kUnitMillimetre, 0.05 * range, 2.0 * range, 0.2 * range);
    period.minimum = std::max(0.5 * finest, kNyquist * spacing_);
    period.maximum = 10.0 * range;
    parameters_.push_back(period);
  }

  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int slot = layout_.axis(axis_);
    const double period = searched_ ? p[2] : period_;
    const double phase = 2.0 * kPi * state.position[axis_] / period;
    const double sine = std::sin(phase), cosine = std::cos(phase);
    sink.add(slot, 0, p[0], sine);
    sink.add(slot, 1, p[1], cosine);
    if (searched_ && sink.wantsDerivatives())
      sink.derivative(slot, 2, -(p[0] * cosine - p[1] * sine) * phase / period);
  }

  /// A wobble is no pure sine: the second harmonic.
  std::vector<ShapeFreedom> freedom(const Domain&) const override {
    if (searched_) return {};
    const std::string key = spec().find("period_mm") != nullptr ? "period_mm" : "period_deg";
    const double unit = key == "period_mm" ? kMillimetre : kDegree;
    return {{EffectSpec(spec()).set(key, 0.5 * period_ / unit)}};
  }
  EffectSpec shapedAs(const std::vector<double>& nonlinear) const override {
    if (!searched_ || nonlinear.empty()) return spec();
    const std::string key = spec().find("period_mm") != nullptr ? "period_mm" : "period_deg";
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", nonlinear[0] / (key == "period_mm" ? kMillimetre : kDegree));
    return EffectSpec(spec()).set(key, std::string(text));
  }
  std::vector<NonlinearFreedom> freedomBeside(const std::vector<double>& nonlinear) const override {
    if (!searched_ || nonlinear.empty()) return {};
    return {{{0.5 * nonlinear[0]}, 0.15}};
  }
  bool mayBeClaimed(const std::vector<double>& nonlinear) const override {
    const double period = searched_ && !nonlinear.empty() ? nonlinear.front() : period_;
    return period <= 0.5 * travel_ && !(searched_ && isAlias(period));
  }
  std::string looksTheSame(const std::vector<double>& nonlinear) const override {
    if (!searched_ || nonlinear.empty() || !(spacing_ > 0.0)) return {};
    const bool linear = parameters_[2].unit == kUnitMillimetre.name;
    const double unit = linear ? kMillimetre : kDegree;
    const std::string name = linear ? " mm" : " deg";
    const double waves = spacing_ / nonlinear.front();  // from one position to the next
    // no screw or scale that is searched for has such a period
    if (linear && spacing_ / (1.0 - waves) < kFinest * kMillimetre) return {};
    const auto text = [&](double value) {
      char digits[32];
      std::snprintf(digits, sizeof digits, "%.3g", value / unit);
      return std::string(digits);
    };
    return "At positions " + text(spacing_) + name + " apart a period of " + text(spacing_ / (1.0 - waves)) +
           " or " + text(spacing_ / (1.0 + waves)) + name + " looks the same" +
           (linear ? commonLeads(waves) : "") + ": measure " + name_ + " at unequal distances.";
  }

 private:
  /// A wave of less than two of the distances at which all positions lie is, at these, the same as a longer
  /// one, and that one is told (Nyquist). ISO 230-2 therefore asks for unequal distances.
  static constexpr double kNyquist = 2.0;
  bool isAlias(double period) const { return period < kNyquist * spacing_; }
  /// Leads that screws are made with and that the same readings fit. @param waves from one position to the
  /// next.
  std::string commonLeads(double waves) const {
    constexpr double kLeads[] = {1.0, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0};  // mm
    constexpr double kPart = 0.25;  // of a wave over the travel: nearer periods cannot be told apart
    std::string leads;
    for (const double lead : kLeads) {
      const double turns = spacing_ / (lead * kMillimetre), seen = std::abs(turns - std::round(turns));
      const bool nearest = std::abs(turns - 1.0) <= 0.5;  // one of the two that are named
      if (nearest || !isAlias(lead * kMillimetre) || std::abs(seen - waves) * travel_ / spacing_ > kPart)
        continue;
      char digits[32];
      std::snprintf(digits, sizeof digits, "%.3g", lead);
      leads += (leads.empty() ? "" : ", ") + std::string(digits);
    }
    return leads.empty() ? "" : ", and so does a screw of " + leads + " mm lead";
  }
  static constexpr double kStep = 1.0 / 3.0;   // of a wave over the range: between two starts
  static constexpr double kMostWaves = 800.0;  // over the range
  static constexpr double kFinest = 0.25;      // mm
  static constexpr int kFewestTeeth = 4;       // fewer are the harmonics of rotary_eccentricity
  static constexpr int kMostTeeth = 400;
  int axis_;
  std::string name_;
  bool searched_ = false;
  double period_ = 0.0, travel_ = 0.0, spacing_ = 0.0;  // m or rad
};

}  // namespace

EffectType leadScrewPeriodicType() {
  const EffectSpec screw = EffectSpec("lead_screw_periodic").set("axis", "x"),
                   worm = EffectSpec("lead_screw_periodic").set("axis", "b");
  return effectType<LeadScrewPeriodic>(
      "lead_screw_periodic", {"axis", "period_mm", "period_deg"},
      [](const Domain& domain) {
        std::vector<EffectSpec> specs;
        for (const std::string& joint : jointNames(domain, JointKind::kLinear))
          specs.push_back(EffectSpec("lead_screw_periodic").set("axis", joint).set("period_mm", "unknown"));
        for (const std::string& joint : jointNames(domain, JointKind::kRotary))
          specs.push_back(EffectSpec("lead_screw_periodic").set("axis", joint).set("period_deg", "unknown"));
        return specs;
      },
      false,
      {EffectSpec(screw).set("period_mm", "unknown"), EffectSpec(screw).set("period_mm", 2),
       EffectSpec(worm).set("period_deg", "unknown"), EffectSpec(worm).set("period_deg", 2)});
}

}  // namespace mm
