#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace mm {

/// What a numeric option takes: a number, both bounds included. A value outside, a text and NaN are refused
/// with the value and the bounds, and the bounds stand in --help. @param unit for people, may be empty.
CLI::Validator numberWithin(double lower, double upper, const std::string& unit = {});
/// The same for a whole number. Of a seed: from 0 to 2^64 - 1.
CLI::Validator wholeNumberWithin(std::uint64_t lower, std::uint64_t upper);
CLI::Validator anySeed();

/// An option that takes what `check` admits. @param what in words, for --help.
template <typename Value>
CLI::Option* checkedOption(CLI::App& command, const std::string& name, Value& value,
                           const CLI::Validator& check, const std::string& what) {
  return command.add_option(name, value, what)->check(check);
}
/// The same, of which --help states the value as it is now: its standard.
template <typename Value>
CLI::Option* standardOption(CLI::App& command, const std::string& name, Value& value,
                            const CLI::Validator& check, const std::string& what) {
  return checkedOption(command, name, value, check, what)->capture_default_str();
}
/// An option that may be given again and again, a value each time.
CLI::Option* repeatedOption(CLI::App& command, const std::string& name, std::vector<std::string>& values,
                            const std::string& what);
/// The option --seed.
void seedOption(CLI::App& command, std::uint64_t& seed);

// What stands within the text of an option. @throw InputError, all of them: naming option, text and
// `example`.

/// The two sides of `name=value`.
std::pair<std::string, std::string> assignmentOf(const std::string& text, const std::string& option,
                                                 const std::string& example);
/// A number, both bounds included.
double optionNumber(const std::string& text, const std::string& option, double lower, double upper,
                    const std::string& example);
/// So many numbers, separated by commas.
std::vector<double> listOfNumbers(const std::string& text, const std::string& option, std::size_t count,
                                  const std::string& example);

}  // namespace mm
