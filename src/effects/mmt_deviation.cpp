#include <cmath>

#include "effects/catalogue_effect.h"
#include "effects/quantity.h"
#include "effects/special_laws.h"

namespace mm {
namespace {

double power(double value, int exponent) {
  return exponent == 0 ? 1.0 : exponent == 1 ? value : value * value;
}

/// MMT eq. (13), one line of it: for X with the other axes Y and Z
///   Cxx1 X + X^a (S sin(k X/Pr) + K cos(k X/Pr)) + Cyx Y^n + Czx Z^n + Y cos(pi/2 + alpha_yx) + Z cos(pi/2 +
///   alpha_zx).
class MmtDeviation : public CatalogueEffect {
 public:
  explicit MmtDeviation(SpecReader& read)
      : CatalogueEffect(read, Stage::kAxis), axis_(read.joint("axis", JointKind::kLinear)) {
    const Domain& domain = read.domain();
    for (int j = 0; j < static_cast<int>(domain.joints.size()); ++j)
      if (j != axis_ && domain.joints[j].kind == JointKind::kLinear) others_.push_back(j);
    if (others_.size() != 2)
      read.fail(
          "mmt_deviation needs a machine with three linear joints; use scale, squareness and the others");
    const double lead = read.number("lead_mm", 1e-4, 1e4) * kMillimetre;
    exponent_ = read.integer("exponent", 1, 2, 2);
    amplitudeExponent_ = read.integer("amplitude_exponent", 0, 1, 1);
    waveNumber_ = (read.choice("argument", {"2pi", "1"}) == "2pi" ? 2.0 * kPi : 1.0) / lead;

    name_ = domain.joints[axis_].name;
    const Unit one{"1", 1.0}, perMetre{"1/m", 1.0};
    parameters_.push_back(parameter("C" + name_ + name_ + "1", one, 1e-4, 0.02));
    for (const char* letter : {"S", "K"})
      parameters_.push_back(amplitudeExponent_ == 1
                                ? parameter(letter + name_ + name_, one, 1e-4, 0.02)
                                : parameter(letter + name_ + name_, kUnitMicrometre, 1e-6, 1e-3));
    for (const int j : others_)
      parameters_.push_back(exponent_ == 2
                                ? parameter("C" + domain.joints[j].name + name_, perMetre, 5e-3, 2.0)
                                : parameter("C" + domain.joints[j].name + name_, one, 1e-4, 0.02));
    for (const int j : others_)
      parameters_.push_back(parameter("alpha_" + domain.joints[j].name + name_, kUnitArcsecond, 1e-4, 0.02));
    nature_.linear = false;
    nature_.separable = true;
    nature_.composite = true;
    nature_.nonlinear = nature_.choosesFrame = {5, 6};  // alpha
    nature_.searchStarts = {{0.0, 0.0}};
    nature_.shapeKeys = {"lead_mm", "exponent", "amplitude_exponent", "argument"};
    nature_.mustMove = {axis_};
    // Whatever the order in which the effects are listed: alpha of an axis by one before it is zero
    // (alpha_xy, alpha_xz, alpha_yz).
    for (int i = 0; i < 2; ++i)
      if (others_[static_cast<std::size_t>(i)] < axis_) nature_.zeroByConvention.push_back(5 + i);
  }

  double coefficient(int parameter, double value) const override {
    return parameter < 5 ? value : std::sin(value);
  }
  void evaluate(const State& state, const double* p, ErrorSink& sink) const override {
    const int slot = layout_.axis(axis_);
    const double q = state.position[axis_];
    const double amplitude = power(q, amplitudeExponent_), phase = waveNumber_ * q;
    const double sine = std::sin(phase), cosine = std::cos(phase);
    sink.add(slot, 0, p[0], q);
    sink.add(slot, 1, p[1], amplitude * sine);
    sink.add(slot, 2, p[2], amplitude * cosine);
    for (int i = 0; i < 2; ++i) {
      const double other = state.position[others_[i]];
      sink.add(slot, 3 + i, p[3 + i], power(other, exponent_));
      // cos(pi/2 + alpha) = -sin(alpha)
      const double alpha = p[5 + i], sine = std::sin(alpha), cosine = std::cos(alpha);
      sink.value(slot, -sine * other);
      if (sink.wantsDerivatives()) sink.derivative(slot, 5 + i, -cosine * other);
    }
  }

 private:
  int axis_;
  std::vector<int> others_;
  int exponent_ = 2, amplitudeExponent_ = 1;
  double waveNumber_ = 0.0;  // 1/m
  std::string name_;
};

}  // namespace

EffectType mmtDeviationType() {
  return effectType<MmtDeviation>("mmt_deviation",
                                  {"axis", "lead_mm", "exponent", "amplitude_exponent", "argument"}, nullptr,
                                  true, {EffectSpec("mmt_deviation").set("axis", "x").set("lead_mm", 2)});
}

}  // namespace mm
