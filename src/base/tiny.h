#pragma once

namespace mm {

/// What a divisor, or the argument of a logarithm, is at the least: smaller than any quantity here, and its
/// inverse is still a number.
inline constexpr double kTiny = 1e-300;

}  // namespace mm
