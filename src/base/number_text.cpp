#include "base/number_text.h"

#include <charconv>
#include <cmath>
#include <limits>

namespace mm {

std::string numberText(double value) {
  if (std::isnan(value)) return ".nan";
  if (std::isinf(value)) return value > 0 ? ".inf" : "-.inf";
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  return {buffer, end};
}

bool parseNumber(const std::string& text, double& value) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (text == ".nan")
    value = std::numeric_limits<double>::quiet_NaN();
  else if (text == ".inf")
    value = kInfinity;
  else if (text == "-.inf")
    value = -kInfinity;
  else {
    const char* end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    return read.ec == std::errc() && read.ptr == end && std::isfinite(value);
  }
  return true;
}

}  // namespace mm
