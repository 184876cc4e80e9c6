#pragma once

namespace mm {

// Factors from the units people read to SI: value_si = value * factor.
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kMillimetre = 1e-3;
inline constexpr double kMicrometre = 1e-6;
inline constexpr double kDegree = kPi / 180.0;
inline constexpr double kArcsecond = kPi / 648000.0;
/// Reference temperature of ISO 1, in degrees Celsius.
inline constexpr double kReferenceTemperature = 20.0;

}  // namespace mm
