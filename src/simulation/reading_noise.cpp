#include "simulation/reading_noise.h"

#include <cmath>
#include <limits>

namespace mm {
namespace {

constexpr double kCorrelation = 0.7;  // with the reading before
constexpr double kTailDof = 3.0;
constexpr double kWildShare = 0.01;                   // of the readings, where tails are heavy
constexpr double kWildLower = 4.0, kWildUpper = 8.0;  // repeatabilities by which these are off

}  // namespace

ReadingNoise::ReadingNoise(const NoiseSettings& noise, const Roughness& rough, std::uint64_t seed,
                           int channels)
    : dof_(rough.tails > 0.0 ? kTailDof : noise.studentDof),
      rough_(rough),
      random_(seed, "contacts"),
      wild_(seed, "rough readings"),
      before_(channels, std::numeric_limits<double>::quiet_NaN()) {}

double ReadingNoise::next(int channel, double size) {
  // One draw a reading whatever its size, so that other settings keep the same noise.
  double draw = dof_ > 0.0 ? random_.student(dof_) : random_.normal();
  double& before = before_[channel];
  if (rough_.correlated > 0.0 && !std::isnan(before))
    draw = kCorrelation * before + std::sqrt(1.0 - kCorrelation * kCorrelation) * draw;
  before = draw;
  return size * rough_.noiseFactor() * draw;
}

double ReadingNoise::wild() {
  const double share = wild_.uniform(), sizes = wild_.uniform(kWildLower, kWildUpper);
  const double sign = wild_.sign();
  return rough_.tails > 0.0 && share < kWildShare ? rough_.tails * sign * sizes : 0.0;
}

double ReadingNoise::read(double value, double size) const {
  const double step = rough_.quantised * size;
  return step > 0.0 ? step * std::round(value / step) : value;
}

}  // namespace mm
