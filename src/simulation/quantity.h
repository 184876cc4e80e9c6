#pragma once
#include <string>

namespace mm {

/// Reads a size with its unit, such as `3um`, `-20 arcsec`, `1.5 um/K`.
/// @param dimension SI unit of the result: m, rad, turn (an angle of any size, rad), 1, s, m/s, m/K, rad/K,
/// 1/K, 1/m; share (a part of something), length and speed (m and m/s of what people write in mm). @return
/// the value in it.
/// @throw InputError naming `where` and the units that fit.
double parseQuantity(const std::string& text, const std::string& dimension, const std::string& where);

/// The unit in which people read a dimension (`um` for m), and its factor to SI.
struct PeopleUnit {
  std::string name;
  double factor = 1.0;
};
/// The unit that is printed for a dimension ("m": um).
PeopleUnit peopleUnit(const std::string& dimension);

}  // namespace mm
