#pragma once
#include <cstddef>
#include <cstdint>

namespace mm {

/// A stream of random numbers that belongs to one (seed, generation, chromosome): SplitMix64 (Steele, Lea and
/// Flood, OOPSLA 2014). The bits depend on nothing else: neither threads, nor order, nor standard library.
class GeneticRandom {
 public:
  GeneticRandom(std::uint64_t seed, std::uint64_t generation, std::uint64_t chromosome)
      : state_(mix(mix(mix(seed + kStep) + generation * kStep) + chromosome * kStep)) {}

  std::uint64_t bits() { return mix(state_ += kStep); }  ///< 64 random bits
  /// Uniform in [0, 1).
  double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  /// Uniform in [-1, 1).
  double symmetric() { return 2.0 * unit() - 1.0; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// One of 0 … count - 1.
  std::size_t below(std::size_t count) {
    return static_cast<std::size_t>(unit() * static_cast<double>(count));
  }

 private:
  static constexpr std::uint64_t kStep = 0x9e3779b97f4a7c15ULL;
  static std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace mm
