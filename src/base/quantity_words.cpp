#include "base/quantity_words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "base/tiny.h"
#include "base/units.h"

namespace mm {
namespace {

constexpr double kResolved = 1e-3;  // um or arcsec: less than any instrument resolves

std::string printed(const char* pattern, int digits, double value) {
  char text[64];
  std::snprintf(text, sizeof text, pattern, digits, value);
  // what is rounded to nothing has no sign
  const std::string number = text;
  return number.find_first_of("123456789") == std::string::npos && number.front() == '-' ? number.substr(1)
                                                                                         : number;
}

}  // namespace

std::string shortNumber(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  return size >= 1000.0 && size < 1e6 ? printed("%.*f", 0, value) : printed("%.*g", 3, value);
}

std::string expanded(double value, double std, const std::string& unit) {
  const std::string suffix = unit.empty() || unit == "1" ? "" : " " + unit;
  if (!std::isfinite(std) || !(std > 0.0)) return shortNumber(value) + suffix;
  const double wide = 2.0 * std;
  int place = static_cast<int>(std::floor(std::log10(wide)));
  if (wide / std::pow(10.0, place) >= 9.5) ++place;      // 0.096 is rounded to 0.10
  const bool two = wide / std::pow(10.0, place) < 2.95;  // one digit of 0.14 would be a third off
  const int decimals = (two ? 1 : 0) - place;
  if (decimals > 6 || decimals < -4 || std::abs(value) >= 1e7)
    return printed("%.*g", 6, value) + " ± " + printed("%.*g", two ? 2 : 1, wide) + suffix;
  return printed("%.*f", std::max(0, decimals), value) + " ± " +
         printed("%.*f", std::max(0, decimals), wide) + suffix;
}

double unitOf(bool angular) { return angular ? kArcsecond : kMicrometre; }
std::string nameOfUnit(bool angular) { return angular ? "arcsec" : "um"; }
std::string errorInWords(double value, bool angular) {
  const double number = value / unitOf(angular);
  const bool below = number != 0.0 && std::abs(number) < kResolved;
  return (below ? "< " + shortNumber(kResolved) : shortNumber(number)) + " " + nameOfUnit(angular);
}
bool positive(double value) { return std::isfinite(value) && value > 0.0; }

std::string withFactor(const std::string& text) {
  return text.find("±") == std::string::npos ? text : text + " (k = 2)";
}

std::string oddsInWords(double probability) {
  if (!std::isfinite(probability)) return "not known";
  const double p = std::clamp(probability, 0.0, 1.0);
  const bool likely = p >= 0.5;
  const double ratio = std::max(p, 1.0 - p) / std::max(kTiny, std::min(p, 1.0 - p));
  const auto said = [&](const std::string& about, const std::string& more, const std::string& less) {
    return about + (likely ? more + " to " + less : less + " to " + more);
  };
  if (ratio < 1.25) return "even";
  if (ratio < 1.75) return said("", "3", "2");
  if (ratio < 9.5) return said("", printed("%.*f", 0, ratio), "1");
  if (ratio > 1000.5) return said(likely ? "more than " : "less than ", "1000", "1");
  const double decade = std::pow(10.0, std::floor(std::log10(ratio)));
  double nearest = decade;
  for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0})
    if (std::abs(std::log(ratio / (step * decade))) < std::abs(std::log(ratio / nearest)))
      nearest = step * decade;
  return said("about ", printed("%.*f", 0, nearest), "1");
}

std::string durationInWords(double seconds) {
  if (seconds < 90.0) return printed("%.*g", 2, seconds) + " s";
  if (seconds < 5400.0) return printed("%.*f", 0, seconds / 60.0) + " min";
  if (seconds < 172800.0) return printed("%.*g", 2, seconds / 3600.0) + " h";
  return printed("%.*g", 2, seconds / 86400.0) + " days";
}

}  // namespace mm
