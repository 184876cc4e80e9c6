#pragma once
#include <algorithm>
#include <cmath>

namespace mm {

/// From the least to the greatest of the values that were added, in their unit; NaN is none.
struct Range {
  double lower = INFINITY, upper = -INFINITY;

  void add(double value) {  ///< NaN is left out
    if (std::isnan(value)) return;
    lower = std::min(lower, value);
    upper = std::max(upper, value);
  }
  bool any() const { return lower <= upper; }                                    ///< values that were added
  double size() const { return upper - lower; }                                  ///< below 0 without any
  double largest() const { return std::max(std::abs(lower), std::abs(upper)); }  ///< without its sign
};

}  // namespace mm
