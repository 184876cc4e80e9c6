#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

namespace mm {

/// One central difference of eighth order, with an estimate of its error.
struct CentralDifference {
  double value = 0.0;
  double error = std::numeric_limits<double>::infinity();  // infinite: f is not finite somewhere within 4 h
  double truncation = 0.0;

  /// Of f at x with steps of h.
  template <class F>
  CentralDifference(F&& f, double x, double h) {
    // Weights of the difference quotients over +-h … +-4h: fourth, sixth and eighth order.
    constexpr double kFourth[4] = {4.0 / 3.0, -1.0 / 3.0, 0.0, 0.0};
    constexpr double kSixth[4] = {3.0 / 2.0, -3.0 / 5.0, 1.0 / 10.0, 0.0};
    constexpr double kEighth[4] = {8.0 / 5.0, -4.0 / 5.0, 8.0 / 35.0, -1.0 / 35.0};
    double fourth = 0.0, sixth = 0.0, largest = 0.0;
    for (int i = 0; i < 4; ++i) {
      const double right = x + (i + 1) * h, left = x - (i + 1) * h;
      const double above = f(right), below = f(left);
      if (!std::isfinite(above) || !std::isfinite(below)) return;
      const double quotient = (above - below) / (right - left);
      fourth += kFourth[i] * quotient;
      sixth += kSixth[i] * quotient;
      value += kEighth[i] * quotient;
      largest = std::max({largest, std::abs(above), std::abs(below)});
    }
    const double coarse = std::abs(sixth - fourth), fine = std::abs(value - sixth);
    truncation = coarse > fine ? fine * (fine / coarse) : fine;
    error = truncation + 2.0 * std::numeric_limits<double>::epsilon() * largest / h;
  }
};

/// Derivative of f at x by central differences of eighth order (relative error near 1e-13 for a smooth f).
/// The first step is small, so that no period of f is mistaken for a slow change; it grows while that lessens
/// the error and the steps agree. Near an edge beyond which f is not finite the step shrinks, at the edge
/// itself the difference is one-sided; NaN only where f is finite on neither side.
/// Not Boost.Math's finite_difference_derivative: it takes one step, whose error it does not compare with
/// those of others, and knows neither periods nor edges.
/// @param typical a typical size of x, for the first step where x is small.
template <class F>
double numericDerivative(F&& f, double x, double typical) {
  constexpr double kGrowth = 8.0;
  constexpr double kNearZero = 1e-3;   // of the typical size: below it the step does not follow x
  constexpr double kFirst = 2e-4;      // of x: short against any period of f that a session can show
  constexpr double kTruncated = 1e-3;  // of the derivative: a step that leaves more out is too long
  constexpr double kShortest = 1e-9;   // of x: below it rounding is all that is left
  constexpr double kOneSided = 1e-4;   // of x: fourth order, a balance of truncation and rounding
  const double size = x != 0.0 ? std::max(std::abs(x), kNearZero * typical) : typical;
  double h = kFirst * size;
  CentralDifference best(f, x, h);
  for (int smaller = 0;
       smaller < 8 && !(best.truncation <= kTruncated * std::abs(best.value) && std::isfinite(best.error));
       ++smaller) {
    h /= kGrowth;
    const CentralDifference next(f, x, h);
    if (next.error < best.error) best = next;
  }
  if (std::isfinite(best.error)) {
    const auto improve = [&](double factor) {
      bool improved = false;
      for (double step = h * factor; step < 8.0 * size && step > kShortest * size; step *= factor) {
        const CentralDifference next(f, x, step);
        if (!(next.error < best.error) || std::abs(next.value - best.value) > 8.0 * (next.error + best.error))
          break;
        best = next;
        improved = true;
      }
      return improved;
    };
    if (!improve(kGrowth)) improve(1.0 / kGrowth);
    return best.value;
  }
  const double centre = f(x);
  for (const double side : {1.0, -1.0}) {
    const double s = side * kOneSided * size;
    const double slope =
        (-25.0 * centre + 48.0 * f(x + s) - 36.0 * f(x + 2 * s) + 16.0 * f(x + 3 * s) - 3.0 * f(x + 4 * s)) /
        (12.0 * s);
    if (std::isfinite(slope)) return slope;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

}  // namespace mm
