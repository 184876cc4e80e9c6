#include "heated_mill.h"

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace mm {
namespace {

constexpr double kStep = 5.0;  // s

}  // namespace

HeatedMill::HeatedMill(std::uint64_t seed, ThermalLaw law) : law_(law) {
  Random random(seed, "mill");
  for (int n = 0; n < kSensors; ++n) {
    capacity_[n] = random.logUniform(2000.0, 12000.0);
    loss_[n] = random.logUniform(0.3, 1.5);
    gain_[n] = 0.0;
  }
  for (int drive = 0; drive < 3; ++drive) {
    const int first = 7 * drive;  // motor, fixed bearing, three parts of the screw, nut, far bearing
    for (int part = 0; part < 6; ++part) link(first + part, first + part + 1, random.logUniform(1.0, 6.0));
    const double strength = drive == 0 ? 1.0 : random.uniform(0.0, 0.3);
    gain_[first] = strength * random.uniform(15.0, 40.0);
    gain_[first + 1] = strength * random.uniform(5.0, 15.0);
    gain_[first + 5] = strength * random.uniform(10.0, 30.0);
    link(first, 29, random.logUniform(0.2, 1.0));
  }
  gain_[21] = random.uniform(40.0, 120.0);  // spindle motor
  for (int n = 21; n < 26; ++n) link(n, n + 1, random.logUniform(2.0, 8.0));
  for (int n = 27; n < 30; ++n) link(n, n + 1, random.logUniform(2.0, 8.0));
  link(26, 27, random.logUniform(1.0, 4.0));
  screw_ = random.uniform(0.4, 0.8) * 11.5;  // um/m/K: a pretensioned screw gives way only in part
  head_ = random.uniform(0.2, 1.0);
  column_ = random.uniform(-0.5, 0.5);
  travel_ = random.uniform(0.4, 0.8);
  knee_ = random.uniform(3.0, 6.0);
  phase_ = random.uniform(0.0, 6.28);
}

MillRun HeatedMill::run(const std::vector<double>& minutes, double start, double load, double noiseT,
                        double noiseY, std::uint64_t seed) const {
  Random random(seed, "warm-up");
  const double swing = random.uniform(0.3, 1.2);
  Temperatures t;
  t.fill(start);
  MillRun result{Eigen::MatrixXd(minutes.size(), kSensors), Eigen::MatrixXd(minutes.size(), kPositions)};
  double time = 0.0;
  for (std::size_t k = 0; k < minutes.size(); ++k) {
    for (; time < 60.0 * minutes[k]; time += kStep)
      advance(t, load, start + swing * std::sin(time / 4000.0 + phase_));
    for (int n = 0; n < kSensors; ++n)
      result.temperatures(static_cast<long>(k), n) =
          t[static_cast<std::size_t>(n)] + noiseT * random.normal();
    for (int p = 0; p < kPositions; ++p)
      result.deviation(static_cast<long>(k), p) =
          deviation(t, travel_ * p / (kPositions - 1)) + noiseY * random.normal();
  }
  return result;
}

void HeatedMill::link(int a, int b, double conductance) {
  links_.push_back({static_cast<std::size_t>(a), static_cast<std::size_t>(b), conductance});
}

void HeatedMill::advance(Temperatures& t, double load, double air) const {
  Temperatures heat;
  for (std::size_t n = 0; n < kSensors; ++n) heat[n] = load * gain_[n] - loss_[n] * (t[n] - air);
  for (const Link& l : links_) {
    heat[l.a] += l.conductance * (t[l.b] - t[l.a]);
    heat[l.b] += l.conductance * (t[l.a] - t[l.b]);
  }
  for (std::size_t n = 0; n + 1 < kSensors; ++n) t[n] += heat[n] * kStep / capacity_[n];
  t[kSensors - 1] = air;
}

/// Effective rise of a part above 20 degC.
double HeatedMill::growth(double rise) const {
  switch (law_) {
    case ThermalLaw::kSaturating:
      return knee_ * (1.0 - std::exp(-rise / knee_));
    case ThermalLaw::kBending:
      return rise * std::abs(rise) / (2.0 * knee_);
    case ThermalLaw::kLinear:
      break;
  }
  return rise;
}

double HeatedMill::deviation(const Temperatures& t, double position) const {
  double length = 0.0;
  for (int part = 0; part < 3; ++part) {
    const double third = travel_ / 3.0;
    const double covered = std::min(std::max(position - part * third, 0.0), third);
    length += screw_ * covered * growth(t[static_cast<std::size_t>(2 + part)] - 20.0);
  }
  return length + head_ * growth(t[24] - 20.0) + column_ * (t[28] - 20.0);
}

}  // namespace mm
