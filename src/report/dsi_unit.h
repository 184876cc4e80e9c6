#pragma once
#include <optional>
#include <string>

namespace mm {

/// A unit of people ("um/m", "arcsec/deg", "1/K") as the D-SI writes it: "\micro\metre\metre\tothe{-1}".
/// @return empty: the D-SI has no such unit (of a covariate, of a user's formula).
std::optional<std::string> dsiUnit(const std::string& unit);

}  // namespace mm
