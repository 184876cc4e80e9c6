#include "tools/bounds.h"

#include <boost/algorithm/string/split.hpp>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/format.h"
#include "base/number_text.h"
#include "base/text.h"

namespace mm {
namespace {

/// Takes a text that is from end to end one number of this type within the bounds.
/// @param kind "a number". @param range the bounds in words.
template <typename Number>
CLI::Validator within(Number lower, Number upper, const std::string& kind, const std::string& range) {
  const auto check = [=](const std::string& text) -> std::string {
    Number value{};
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    if (error == std::errc() && stop == end && value >= lower && value <= upper) return {};
    return "'" + text + "' is not " + kind + " from " + range;
  };
  return CLI::Validator(check, "[" + range + "]");
}

}  // namespace

CLI::Validator numberWithin(double lower, double upper, const std::string& unit) {
  const std::string range = format("%.9g to %.9g", lower, upper) + (unit.empty() ? "" : " " + unit);
  return within(lower, upper, "a number", range);
}

CLI::Validator wholeNumberWithin(std::uint64_t lower, std::uint64_t upper) {
  return within(lower, upper, "a whole number", std::to_string(lower) + " to " + std::to_string(upper));
}

CLI::Validator anySeed() {
  const std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  return CLI::Validator(wholeNumberWithin(0, most)).description("");
}

CLI::Option* repeatedOption(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                            const std::string& what) {
  return command.add_option(name, values, what)->take_all()->allow_extra_args(false);
}

void seedOption(CLI::App& command, std::uint64_t& seed) {
  standardOption(command, "--seed", seed, anySeed(), "seed of the random number generator");
}

std::pair<std::string, std::string> assignmentOf(const std::string& text, const std::string& option,
                                                 const std::string& example) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || at + 1 == text.size())
    throw InputError(option + " '" + text + "' is not name=value; write " + example);
  return {text.substr(0, at), text.substr(at + 1)};
}

double optionNumber(const std::string& text, const std::string& option, double lower, double upper,
                    const std::string& example) {
  double value = 0.0;
  const std::string bare(trim(text));
  if (!parseNumber(bare, value) || !(value >= lower && value <= upper))
    throw InputError(option + ": '" + bare + "' is not a number from " + numberText(lower) + " to " +
                     numberText(upper) + "; write " + example);
  return value;
}

std::vector<double> listOfNumbers(const std::string& text, const std::string& option, std::size_t count,
                                  const std::string& example) {
  std::vector<std::string> parts;
  boost::split(parts, text, [](char c) { return c == ','; });
  std::vector<double> values;
  for (const std::string& part : parts) values.push_back(optionNumber(part, option, -1e9, 1e9, example));
  if (values.size() != count)
    throw InputError(option + " '" + text + "' has " + std::to_string(values.size()) + " numbers, it needs " +
                     std::to_string(count) + "; write " + example);
  return values;
}

}  // namespace mm
