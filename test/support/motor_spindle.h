#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "spindle_simulation.h"

namespace mm::test_support {

/// A spindle with a built-in motor, as a network of lumps: a hollow housing of 12 rings in three sectors, a
/// shaft of 6 lumps, a bed; bearings whose losses fall as they warm, free convection that grows with the
/// power 1.25 of the temperature difference, a cooling jacket on every second one. 36 sensors with lags of
/// their own. The nose moves by the rings before the foot, by the shaft, a little with its square too, by the
/// tilt of the sectors and by the bed. Neither linear nor of the geometry of RandomSpindle.
class MotorSpindle {
 public:
  static constexpr int kSensors = 36;

  explicit MotorSpindle(std::uint64_t seed) {
    RandomNumbers random(31337 + seed);
    for (double& c : housing_) c = random.logarithmic(1500.0, 4000.0);
    for (double& c : shaft_) c = random.logarithmic(800.0, 2000.0);
    bed_ = random.logarithmic(2e4, 8e4);
    along_ = random.logarithmic(3.0, 12.0);
    around_ = random.logarithmic(2.0, 8.0);
    inShaft_ = random.logarithmic(2.0, 8.0);
    toBed_ = random.logarithmic(1.0, 5.0);
    for (double& h : convection_) h = random.logarithmic(0.1, 0.8);
    contact_ = random.logarithmic(1.0, 5.0);
    power_[0] = random.logarithmic(80.0, 300.0);
    power_[1] = random.logarithmic(30.0, 200.0);
    power_[2] = random.logarithmic(20.0, 300.0);
    jacket_ = random.uniform(0.0, 1.0) < 0.5 ? 0.0 : random.logarithmic(0.5, 4.0);
    place_[0] = 1 + static_cast<int>(random.uniform(0.0, 2.99));
    place_[1] = 8 + static_cast<int>(random.uniform(0.0, 2.99));
    place_[2] = 6;
    softening_ = random.uniform(0.0, 0.4);
    for (double& w : ringGrowth_) w = random.uniform(0.2, 0.6);
    for (double& w : shaftGrowth_) w = random.uniform(-0.1, 0.5);
    tilt_ = random.uniform(-0.6, 0.6);
    square_ = random.uniform(0.0, 0.004);
    bedGrowth_ = random.uniform(-0.5, 0.5);
    for (double& l : lag_) l = random.logarithmic(5.0, 60.0);
    swing_ = random.uniform(0.0, 1.5);
    phase_ = random.uniform(0.0, 6.0);
    noiseT_ = random.logarithmic(0.03, 0.15);
    noiseY_ = random.logarithmic(0.1, 0.6);
  }

  /// `samples` over two hours; the displacement is exact where it is to be judged against.
  SpindleRun run(const Duty& duty, int samples, bool exact, std::uint64_t seed) const {
    RandomNumbers random(seed);
    Field now;
    double read[kSensors];
    std::fill(std::begin(read), std::end(read), kStart);
    SpindleRun result{Eigen::MatrixXd(samples, kSensors), Eigen::VectorXd(samples)};
    double time = 0.0;
    for (int k = 0; k < samples; ++k) {
      for (; time < 7200.0 * (k + 1) / samples; time += kStep) {
        advance(now, duty(time), kStart + swing_ * (std::sin(time / 4000.0 + phase_) - std::sin(phase_)));
        for (int s = 0; s < kSensors; ++s) read[s] += (now.housing[s] - read[s]) * kStep / lag_[s];
      }
      for (int s = 0; s < kSensors; ++s) result.temperatures(k, s) = read[s] + random.normal(noiseT_);
      result.displacement(k) = displacement(now) + (exact ? 0.0 : random.normal(noiseY_));
    }
    return result;
  }

 private:
  static constexpr double kStart = 21.0, kStep = 4.0;  // degC, s
  struct Field {
    double housing[kSensors], shaft[6], bed = kStart;  // degC; ring i, sector j: 3 i + j
    Field() {
      std::fill(std::begin(housing), std::end(housing), kStart);
      std::fill(std::begin(shaft), std::end(shaft), kStart);
    }
  };

  void advance(Field& t, double duty, double air) const {
    double housing[kSensors] = {}, shaft[6] = {}, bed = 20.0 * (air - t.bed);  // W
    const auto exchange = [](double a, double b, double conductance, double& heatA, double& heatB) {
      heatA += conductance * (b - a);
      heatB -= conductance * (b - a);
    };
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 3; ++j) {
        const int c = 3 * i + j, beside = 3 * i + (j + 1) % 3;
        if (i < 11) exchange(t.housing[c], t.housing[c + 3], along_, housing[c], housing[c + 3]);
        exchange(t.housing[c], t.housing[beside], around_, housing[c], housing[beside]);
        const double rise = t.housing[c] - air;
        housing[c] -= convection_[j] * rise * std::pow(std::abs(rise) + 0.1, 0.25);
        if (i >= 4 && i <= 7) housing[c] -= jacket_ * (t.housing[c] - kStart);
        if (j == 2 && i >= 6) exchange(t.housing[c], t.bed, toBed_, housing[c], bed);
      }
    for (int i = 0; i < 5; ++i) exchange(t.shaft[i], t.shaft[i + 1], inShaft_, shaft[i], shaft[i + 1]);
    for (int source = 0; source < 3; ++source) {
      const int ring = place_[source], on = ring / 2;
      const double heat = power_[source] * duty * (1.0 - softening_ * (t.shaft[on] - kStart) / 40.0);
      shaft[on] += 0.4 * heat;
      for (int c = 3 * ring; c < 3 * ring + 3; ++c) {
        housing[c] += 0.2 * heat;
        exchange(t.housing[c], t.shaft[on], contact_ / 3.0, housing[c], shaft[on]);
      }
    }
    for (int c = 0; c < kSensors; ++c) t.housing[c] += housing[c] * kStep / housing_[c];
    for (int i = 0; i < 6; ++i) t.shaft[i] += shaft[i] * kStep / shaft_[i];
    t.bed += bed * kStep / bed_;
  }

  double displacement(const Field& t) const {
    double grown = bedGrowth_ * (t.bed - kStart), shaft = 0.0;
    for (int i = 0; i < 12; ++i) {
      const double* ring = t.housing + 3 * static_cast<std::ptrdiff_t>(i);
      if (i < 8) grown += ringGrowth_[i] * ((ring[0] + ring[1] + ring[2]) / 3.0 - kStart);
      grown += tilt_ * (ring[0] - ring[2]) * 0.025 * i;
    }
    for (int i = 0; i < 6; ++i) shaft += shaftGrowth_[i] * (t.shaft[i] - kStart);
    return grown + shaft + square_ * shaft * shaft;
  }

  double housing_[kSensors], shaft_[6], bed_;                                   // J/K
  double along_, around_, inShaft_, toBed_, contact_, convection_[3], jacket_;  // W/K; convection W/K^1.25
  double power_[3], softening_;                                                 // W; bearings and motor
  int place_[3];                                                                // rings
  double ringGrowth_[12], shaftGrowth_[6], tilt_, square_, bedGrowth_;          // um/K, um^-1
  double lag_[kSensors], swing_, phase_, noiseT_, noiseY_;                      // s, K, rad, K, um
};

}  // namespace mm::test_support
