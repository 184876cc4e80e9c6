#pragma once
#include <cstdint>

namespace mm {

/// Seconds from `start` to `stamp`, both whole nanoseconds. All readers use it, so that equal stamps give
/// equal bits.
inline double secondsBetween(std::int64_t start, std::int64_t stamp) {
  return static_cast<double>(stamp - start) / 1e9;
}

}  // namespace mm
