#pragma once
#include <limits>
#include <string>
#include <vector>

namespace mm {

/// Whether a figure conforms with a specification, by ISO 14253-1:2017: it does, or does not, where that has
/// a probability of 95 % or more in view of the figure's standard uncertainty; between these nothing is
/// proven. With one limit near, the guard band is 1.645 standard uncertainties.
enum class Conformity { kConforms, kUndecided, kDoesNotConform };
/// "conforms", "not proven", "does not conform".
const char* nameOf(Conformity conformity);

/// Limits of a figure, in its own unit; an infinite one is no limit.
struct Specification {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
};

inline constexpr double kConformanceProbability = 0.95;  // the default of ISO 14253-1

/// Probability that the true value is within the limits, of a normal distribution. @param std > 0, or 0: the
/// value is certain.
double probabilityWithin(double value, double std, const Specification& specification);
Conformity judge(double value, double std, const Specification& specification);

/// Values that conform with their uncertainty: the specification less guard bands. Empty: none does, as the
/// uncertainty is too large for the tolerance.
struct AcceptanceZone {
  bool exists = false;
  double lower = 0.0, upper = 0.0;
};
/// Of a tolerance, for a measurement of standard uncertainty `std`; ISO 14253-1. Units as the specification.
AcceptanceZone acceptanceZone(double std, const Specification& specification);

/// Maximum permissible error of a length, ISO 10360-1: the smaller of A + L / K and B. A, B: um; L: mm.
struct PermissibleError {
  double a = 0.0, k = std::numeric_limits<double>::infinity(), b = std::numeric_limits<double>::infinity();
  double at(double lengthMm) const;  ///< um
  std::string inWords() const;       ///< "1.2 um + L/250"
};

/// One length of an acceptance test.
struct TestLength {
  double length = 0.0;  // mm, calibrated
  double error = 0.0;   // um, measured minus calibrated
  double std = 0.0;     // um, standard uncertainty of the test value
};
/// An A + L / K that no |error| + 2 std exceeds, each length for itself: the slope by least squares, not
/// negative, with the smallest A that does.
PermissibleError permissibleFor(const std::vector<TestLength>& lengths);

}  // namespace mm
