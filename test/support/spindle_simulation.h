#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "random_numbers.h"

namespace mm::test_support {

/// Relative power of the bearings (0 stopped, 1 full speed) at a time in s.
using Duty = std::function<double(double)>;

/// SENSORS: run 600 s, stop 300 s, run 1200 s, stop 300 s, run until 2 h.
inline Duty patentDuty() {
  return [](double t) { return (t < 600 || (t >= 900 && t < 2100) || t >= 2400) ? 1.0 : 0.0; };
}

/// Steps of 5 to 25 min at random speeds, with stops between; bearing losses grow with the power 1.3 of
/// speed.
inline Duty randomDuty(std::uint64_t seed) {
  RandomNumbers random(seed);
  std::vector<std::pair<double, double>> steps;
  for (double t = 0.0; t < 8000.0; t += random.uniform(300.0, 1500.0))
    steps.emplace_back(t, random.uniform(0.0, 1.0) < 0.3 ? 0.0 : std::pow(random.uniform(0.3, 1.1), 1.3));
  return [steps](double t) {
    double power = 0.0;
    for (const auto& step : steps)
      if (t >= step.first) power = step.second;
    return power;
  };
}

/// What one warm-up leaves: 54 temperatures in degC and the displacement of the nose in um.
struct SpindleRun {
  Eigen::MatrixXd temperatures;
  Eigen::VectorXd displacement;
};

/// A spindle housing as heat sees it: a block of finite volumes with two bearings as heat sources, a shaft
/// between them, convection on every face. The nose moves by the expansion of the housing from its foot to
/// the front, by that of the shaft before the front bearing, and by the bending of the block (warmer at the
/// top than at the bottom).
class RandomSpindle {
 public:
  explicit RandomSpindle(std::uint64_t seed) {
    RandomNumbers random(seed);
    length_ = random.uniform(0.30, 0.45);
    side_ = random.uniform(0.12, 0.18);
    front_ = random.uniform(0.06, 0.10);
    rear_ = length_ - random.uniform(0.06, 0.10);
    conductivity_ = random.uniform(40.0, 55.0);
    capacity_ = random.uniform(3.4e6, 3.9e6);
    for (double& h : convection_) h = random.logarithmic(5.0, 30.0);
    frontPower_ = random.logarithmic(60.0, 300.0);
    rearPower_ = frontPower_ * random.uniform(0.3, 1.0);
    shaftShare_ = random.uniform(0.2, 0.5);
    shaftCapacity_ = random.uniform(1500.0, 5000.0);
    shaftLoss_ = random.uniform(0.5, 3.0);
    shaftContact_ = random.uniform(1.0, 6.0);
    foot_ = random.uniform(0.4, 1.0) * length_;
    nose_ = random.uniform(0.03, 0.10);
    bending_ = random.uniform(0.0, 1.0);
    swing_ = random.uniform(0.0, 1.0);
    phase_ = random.uniform(0.0, 6.28);
  }

  /// Distance of the bearings in m, and where along it sensor s (0 … 53) lies (0 front bearing, 1 rear
  /// bearing).
  double bearingDistance() const { return rear_ - front_; }
  double place(int sensor) const { return (x(1 + sensor % 18) - front_) / bearingDistance(); }

  /// `samples` over two hours, with noise in K and um of the given standard deviations.
  SpindleRun run(const Duty& duty, int samples, double noiseT, double noiseY, std::uint64_t seed) const {
    RandomNumbers random(seed);
    const double dx = length_ / kX, dy = side_ / kY;
    const double gx = conductivity_ * dy * dy / dx, gy = conductivity_ * dx;
    const double c = capacity_ * dx * dy * dy;
    const double step = 0.4 * c / (2 * gx + 4 * gy);
    std::vector<double> t(kX * kY * kY, 20.0), next(t);
    double shaft = 20.0;
    SpindleRun result{Eigen::MatrixXd(samples, 54), Eigen::VectorXd(samples)};
    double time = 0.0;
    for (int k = 0; k < samples; ++k) {
      const double until = 7200.0 * (k + 1) / samples;
      while (time < until) {
        const double dt = std::min(step, until - time);
        advance(t, next, shaft, duty(time), ambient(time), dt, gx, gy, c, dx, dy);
        time += dt;
      }
      for (int s = 0; s < 54; ++s) result.temperatures(k, s) = t[sensorCell(s)] + random.normal(noiseT);
      result.displacement(k) = displacement(t, shaft, dx) + random.normal(noiseY);
    }
    return result;
  }

 private:
  static constexpr int kX = 20, kY = 5;  // cells along the axis and across
  static std::size_t cell(int i, int j, int k) { return static_cast<std::size_t>((i * kY + j) * kY + k); }
  double x(int i) const { return length_ * (i + 0.5) / kX; }
  double ambient(double t) const {
    return 20.0 + swing_ * (std::sin(t / 3000.0 + phase_) - std::sin(phase_));
  }
  /// 18 places along the axis on the top, the left and the right face, of which the last two sit off the
  /// middle.
  static std::size_t sensorCell(int s) {
    const int i = 1 + s % 18;
    return s < 18 ? cell(i, kY / 2, kY - 1) : s < 36 ? cell(i, 0, 3) : cell(i, kY - 1, 1);
  }

  void advance(std::vector<double>& t, std::vector<double>& next, double& shaft, double power, double air,
               double dt, double gx, double gy, double c, double dx, double dy) const {
    const int front = static_cast<int>(front_ / length_ * kX), rear = static_cast<int>(rear_ / length_ * kX);
    double toShaft = 0.0;
    for (int i = 0; i < kX; ++i)
      for (int j = 0; j < kY; ++j)
        for (int k = 0; k < kY; ++k) {
          const double here = t[cell(i, j, k)];
          double heat = 0.0;
          heat += i > 0 ? gx * (t[cell(i - 1, j, k)] - here) : convection_[0] * dy * dy * (air - here);
          heat += i < kX - 1 ? gx * (t[cell(i + 1, j, k)] - here) : convection_[1] * dy * dy * (air - here);
          heat += j > 0 ? gy * (t[cell(i, j - 1, k)] - here) : convection_[2] * dx * dy * (air - here);
          heat += j < kY - 1 ? gy * (t[cell(i, j + 1, k)] - here) : convection_[3] * dx * dy * (air - here);
          heat += k > 0 ? gy * (t[cell(i, j, k - 1)] - here) : convection_[4] * dx * dy * (air - here);
          heat += k < kY - 1 ? gy * (t[cell(i, j, k + 1)] - here) : convection_[5] * dx * dy * (air - here);
          const bool ring = j >= 1 && j <= 3 && k >= 1 && k <= 3 && !(j == 2 && k == 2);
          if (ring && (i == front || i == rear)) {
            heat += power * (1.0 - shaftShare_) * (i == front ? frontPower_ : rearPower_) / 8.0;
            heat -= shaftContact_ * (here - shaft) / 8.0;
            toShaft += shaftContact_ * (here - shaft) / 8.0;
          }
          next[cell(i, j, k)] = here + heat * dt / c;
        }
    shaft += (toShaft + power * shaftShare_ * (frontPower_ + rearPower_) - shaftLoss_ * (shaft - air)) * dt /
             shaftCapacity_;
    t.swap(next);
  }

  double displacement(const std::vector<double>& t, double shaft, double dx) const {
    constexpr double kExpansion = 11.5e-6;
    double grown = 0.0, bent = 0.0;
    for (int i = 0; i < kX; ++i) {
      double mean = 0.0, top = 0.0, bottom = 0.0;
      for (int j = 0; j < kY; ++j) {
        top += t[cell(i, j, kY - 1)] / kY;
        bottom += t[cell(i, j, 0)] / kY;
        for (int k = 0; k < kY; ++k) mean += t[cell(i, j, k)] / (kY * kY);
      }
      if (x(i) < foot_) {
        grown += kExpansion * (mean - 20.0) * dx;
        bent += kExpansion * (top - bottom) / side_ * dx * x(i);
      }
    }
    grown += kExpansion * (shaft - 20.0) * (front_ + nose_);
    return 1e6 * (grown + bending_ * bent);
  }

  double length_, side_, front_, rear_, conductivity_, capacity_, convection_[6], frontPower_, rearPower_,
      shaftShare_, shaftCapacity_, shaftLoss_, shaftContact_, foot_, nose_, bending_, swing_, phase_;
};

}  // namespace mm::test_support
