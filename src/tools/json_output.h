#pragma once
#include <nlohmann/json.hpp>
#include <ostream>

namespace mm {

/// A number, or null where it is NaN or infinite. @param toUnit value for people = SI value * toUnit.
nlohmann::json jsonNumber(double si, double toUnit = 1.0);
inline nlohmann::json jsonMicrometres(double metres) { return jsonNumber(metres, 1e6); }

/// Prints `value` and a line break; NaN and infinite numbers anywhere inside become null, and numbers read
/// back to the bit.
void printJson(std::ostream& out, const nlohmann::ordered_json& value);

}  // namespace mm
