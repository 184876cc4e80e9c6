#pragma once

namespace mm {

/// What a divisor, or the argument of a logarithm, is at the least: smaller than any quantity here, and its
/// inverse is still a number.
inline constexpr double kTiny = 1e-300;

/// By what a quotient that ought to be a whole number may miss it through rounding.
inline constexpr double kOfAWhole = 1e-9;

}  // namespace mm
