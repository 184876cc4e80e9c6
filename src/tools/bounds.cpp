#include "tools/bounds.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/format.h"

namespace mm {
namespace {

/// Whether the whole text is one number of this type.
template <typename Number>
bool parsed(const std::string& text, Number& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

}  // namespace

CLI::Validator numberWithin(double lower, double upper, const std::string& unit) {
  const std::string range = format("%.9g to %.9g", lower, upper) + (unit.empty() ? "" : " " + unit);
  return CLI::Validator(
      [lower, upper, range](std::string& text) -> std::string {
        double value = 0.0;
        if (parsed(text, value) && value >= lower && value <= upper) return {};
        return "'" + text + "' is not a number from " + range;
      },
      "[" + range + "]");
}

CLI::Validator wholeNumberWithin(std::uint64_t lower, std::uint64_t upper) {
  const std::string range = std::to_string(lower) + " to " + std::to_string(upper);
  return CLI::Validator(
      [lower, upper, range](std::string& text) -> std::string {
        std::uint64_t value = 0;
        if (parsed(text, value) && value >= lower && value <= upper) return {};
        return "'" + text + "' is not a whole number from " + range;
      },
      "[" + range + "]");
}

CLI::Validator anySeed() {
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  return CLI::Validator(wholeNumberWithin(0, most)).description("");
}

}  // namespace mm
