#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace mm {

/// Derivative of f at x by central differences of eighth order, with a step chosen by the truncation that the
/// sixth and fourth orders show against the rounding error; two steps must agree. Near an edge beyond which f
/// is not finite the step shrinks, at the edge itself the difference is one-sided; NaN only where f is not
/// finite on either side.
/// @param typical a typical size of x, for the first step where x is small.
template <class F>
double numericDerivative(F&& f, double x, double typical) {
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  // Weights of the difference quotients over +-h … +-4h: fourth, sixth and eighth order.
  constexpr double kFourth[4] = {4.0 / 3.0, -1.0 / 3.0, 0.0, 0.0};
  constexpr double kSixth[4] = {3.0 / 2.0, -3.0 / 5.0, 1.0 / 10.0, 0.0};
  constexpr double kEighth[4] = {8.0 / 5.0, -4.0 / 5.0, 8.0 / 35.0, -1.0 / 35.0};
  // An odd factor: steps that are simple fractions meet the periods of sines and see nothing.
  const double first = 0.1173 * std::max(std::abs(x), typical);
  const double last = 1e-5 * (x != 0.0 ? std::abs(x) : typical);

  double previous = 0.0, previousError = -1.0;  // negative: none
  double fallback = std::numeric_limits<double>::quiet_NaN(),
         disagreement = std::numeric_limits<double>::infinity();
  for (double h = first; h > last; h *= 0.27) {
    double fourth = 0.0, sixth = 0.0, eighth = 0.0, largest = 0.0;
    bool finite = true;
    for (int i = 0; i < 4 && finite; ++i) {
      const double right = x + (i + 1) * h, left = x - (i + 1) * h;
      const double above = f(right), below = f(left);
      finite = std::isfinite(above) && std::isfinite(below);
      const double quotient = (above - below) / (right - left);
      fourth += kFourth[i] * quotient;
      sixth += kSixth[i] * quotient;
      eighth += kEighth[i] * quotient;
      largest = std::max({largest, std::abs(above), std::abs(below)});
    }
    if (!finite) continue;
    const double coarse = std::abs(sixth - fourth), fine = std::abs(eighth - sixth);
    const double truncation = coarse > fine ? fine * (fine / coarse) : fine;
    const double error = truncation + 2.0 * kEpsilon * largest / h;
    if (previousError >= 0.0) {
      const double gap = std::abs(eighth - previous);
      if (gap <= 8.0 * (error + previousError) && std::min(error, previousError) <= 1e-9 * std::abs(eighth))
        return error < previousError ? eighth : previous;
      if (gap < disagreement) {
        disagreement = gap;
        fallback = error < previousError ? eighth : previous;
      }
    }
    previous = eighth;
    previousError = error;
  }
  if (std::isfinite(fallback)) return fallback;
  const double centre = f(x);
  for (const double side : {1.0, -1.0}) {
    const double h = side * 1e-4 * (x != 0.0 ? std::abs(x) : typical);
    const double slope =
        (-25.0 * centre + 48.0 * f(x + h) - 36.0 * f(x + 2 * h) + 16.0 * f(x + 3 * h) - 3.0 * f(x + 4 * h)) /
        (12.0 * h);
    if (std::isfinite(slope)) return slope;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace mm
