#pragma once
#include <cmath>
#include <cstdint>
#include <random>

namespace mm::test_support {

/// Seeded numbers that are the same on every platform.
class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint64_t seed) : engine_(seed * 0x9E3779B97F4A7C15u + 1) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  double normal(double deviation) {
    const double u = uniform(1e-300, 1.0), v = uniform(0.0, 6.283185307179586);
    return deviation * std::sqrt(-2.0 * std::log(u)) * std::cos(v);
  }
  /// Between low and high, evenly in the logarithm.
  double logarithmic(double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace mm::test_support
