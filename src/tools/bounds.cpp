#include "tools/bounds.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/format.h"
#include "base/number_text.h"
#include "base/text.h"

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
  std::vector<double> values;
  std::size_t from = 0;
  for (;;) {
    const std::size_t end = text.find(',', from);
    values.push_back(optionNumber(text.substr(from, end - from), option, -1e9, 1e9, example));
    if (end == std::string::npos) break;
    from = end + 1;
  }
  if (values.size() != count)
    throw InputError(option + " '" + text + "' has " + std::to_string(values.size()) + " numbers, it needs " +
                     std::to_string(count) + "; write " + example);
  return values;
}

}  // namespace mm
