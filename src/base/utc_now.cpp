#include "base/utc_now.h"

#include <cmath>
#include <ctime>

namespace mm {

std::string utcText(double epoch, const char* format) {
  constexpr double kLast = 1e15;  // s, beyond which a year is no int
  if (!(std::abs(epoch) < kLast)) return {};
  const auto seconds = static_cast<std::time_t>(std::floor(epoch));
  std::tm utc{};
  char text[64];
  if (gmtime_r(&seconds, &utc) == nullptr) return {};
  return std::string(text, std::strftime(text, sizeof text, format, &utc));
}

std::string utcNow(const char* format) { return utcText(static_cast<double>(std::time(nullptr)), format); }

}  // namespace mm
