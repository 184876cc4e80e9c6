#pragma once
#include <string>

namespace mm {

/// The shortest text that reads back to the same bits; `.nan`, `.inf` and `-.inf` as in YAML. Never depends
/// on the locale.
std::string numberText(double value);

/// @return false when `text` is not one number and nothing else.
bool parseNumber(const std::string& text, double& value);

}  // namespace mm
