#pragma once
#include <string>

namespace mm {

// Numbers as people say them. Every uncertainty after ± is expanded, with the coverage factor k = 2.

/// A probability as odds: "even", "3 to 2", "about 30 to 1", "more than 1000 to 1"; below one half the other
/// way round.
std::string oddsInWords(double probability);
/// A time: "40 s", "20 min", "3.5 h", "2.1 days".
std::string durationInWords(double seconds);
/// Value and expanded uncertainty (twice `std`), this with one digit, or two where it begins with 1 or 2:
/// "2.06 ± 0.06 um".
std::string expanded(double value, double std, const std::string& unit);
/// "2.06 ± 0.06 um (k = 2)": the coverage factor behind what has an uncertainty.
std::string withFactor(const std::string& text);
/// An error in um, or in arcsec: "0.3 um"; "< 0.001 um" below what any instrument resolves. @param value m or
/// rad.
std::string errorInWords(double value, bool angular);
double unitOf(bool angular);  ///< m or rad of one of these
std::string nameOfUnit(bool angular);
bool positive(double value);  ///< and finite: a figure that is known
/// A number with three significant digits.
std::string shortNumber(double value);

}  // namespace mm
