#pragma once
#include <cstdint>
#include <string>

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

}  // namespace mm
