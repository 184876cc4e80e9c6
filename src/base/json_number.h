#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace mm {

/// A number, or null where it is NaN or infinite.
inline nlohmann::ordered_json number(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace mm
