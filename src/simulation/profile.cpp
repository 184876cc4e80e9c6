#include "simulation/profile.h"

#include <algorithm>
#include <cmath>

#include "base/units.h"

namespace mm {
namespace {

constexpr double kNoTravel = 1e-9;  // m or rad: of a joint that stands still

constexpr int kPoints = 513;
constexpr int kWaves = 4;

std::vector<double> randomWaves(Random& random) {
  double amplitude[kWaves], phase[kWaves], waves[kWaves];
  for (int k = 0; k < kWaves; ++k) {
    amplitude[k] = random.uniform(0.6, 1.0) / ((k + 1.0) * (k + 1.0));
    phase[k] = random.uniform(0.0, 2.0 * kPi);
    waves[k] = random.uniform(0.4, 0.8) * (k + 1.0);
  }
  std::vector<double> values(kPoints, 0.0);
  for (int i = 0; i < kPoints; ++i)
    for (int k = 0; k < kWaves; ++k)
      values[i] += amplitude[k] * std::sin(2.0 * kPi * waves[k] * i / (kPoints - 1.0) + phase[k]);
  return values;
}

}  // namespace

Profile::Profile(double lower, double upper, std::vector<double> values, double size)
    : lower_(lower), upper_(upper > lower ? upper : lower + kNoTravel), values_(std::move(values)) {
  const double n = static_cast<double>(values_.size()), middle = 0.5 * (n - 1.0);
  double mean = 0.0, slope = 0.0, largest = 0.0;
  for (std::size_t i = 0; i < values_.size(); ++i) mean += values_[i] / n;
  for (std::size_t i = 0; i < values_.size(); ++i)
    slope += (i - middle) * values_[i] * 12.0 / (n * (n * n - 1.0));
  for (std::size_t i = 0; i < values_.size(); ++i) values_[i] -= mean + slope * (i - middle);
  for (const double v : values_) largest = std::max(largest, std::abs(v));
  for (double& v : values_) v *= size / largest;
}

Profile Profile::waves(double lower, double upper, double size, Random& random) {
  return {lower, upper, randomWaves(random), size};
}

Profile Profile::integratedWaves(double lower, double upper, double size, Random& random) {
  std::vector<double> rate = randomWaves(random), sum(rate.size(), 0.0);
  for (std::size_t i = 1; i < rate.size(); ++i) sum[i] = sum[i - 1] + 0.5 * (rate[i - 1] + rate[i]);
  return {lower, upper, std::move(sum), size};
}

Profile Profile::rise(double lower, double upper, double size, Random& random) {
  Profile profile = waves(lower, upper, 0.12, random);
  for (int i = 0; i < kPoints; ++i)
    profile.values_[i] = size * (profile.values_[i] + 2.0 * i / (kPoints - 1.0) - 1.0);
  return profile;
}

double Profile::at(double travel) const {
  const double steps = static_cast<double>(values_.size() - 1);
  const double x = std::clamp((travel - lower_) / (upper_ - lower_), 0.0, 1.0) * steps;
  const std::size_t i = std::min(static_cast<std::size_t>(x), values_.size() - 2);
  return values_[i] + (x - i) * (values_[i + 1] - values_[i]);
}

}  // namespace mm
