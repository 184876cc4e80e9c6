#pragma once
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace CLI {
class Validator;
}

namespace mm {

/// What a numeric option takes: a number, both bounds included. A value outside, a text and NaN are refused
/// with the value and the bounds, and the bounds stand in --help. @param unit for people, may be empty.
CLI::Validator numberWithin(double lower, double upper, const std::string& unit = {});
/// The same for a whole number. Of a seed: from 0 to 2^64 - 1.
CLI::Validator wholeNumberWithin(std::uint64_t lower, std::uint64_t upper);
CLI::Validator anySeed();

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
