#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mm {

enum class UnitKind { kLength, kAngle, kTime, kTemperature, kSpeed, kTurning };

/// A unit as people write it. SI value (degC of a temperature) = written * factor + offset.
struct Unit {
  UnitKind kind = UnitKind::kLength;
  double factor = 1.0;
  double offset = 0.0;
  std::string symbol;  // as this package writes it: "mm", "arcsec", "degC", "mm/s"

  /// Whether a gauge shows lengths in it, and no axis where it stands: um, nm, microinch.
  bool ofAGauge() const {
    constexpr double kFinerThanAnAxis = 1e-5;  // m
    return kind == UnitKind::kLength && factor < kFinerThanAnAxis;
  }
};

/// Reads `mm`, `µm`, `inch`, `"`, `°C`, `deg C`, `arcsec`, `mm/min`, `mm_s` and their like in any case.
/// Nothing for what is no unit of length, angle, time, temperature or speed.
/// @param kind what it must be, where a symbol means two things (m, ", ').
std::optional<Unit> parseUnit(std::string_view text, std::optional<UnitKind> kind = std::nullopt);

/// What people are told of a kind of unit.
struct UnitKindFacts {
  std::string inWords;               // "a length (mm, um, m, inch)"
  std::vector<std::string> choices;  // as a column's name ends with them: mm, mm_s; the likeliest first
};
const UnitKindFacts& factsOf(UnitKind kind);  ///< by the order of UnitKind

}  // namespace mm
