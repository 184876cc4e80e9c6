#pragma once
#include <random>

namespace mm {

/// A number in [0, 1) of 53 bits: the same for a seed with every standard library, whose own distributions
/// are not.
inline double unitRandom(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

}  // namespace mm
