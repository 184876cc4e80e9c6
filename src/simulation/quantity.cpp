#include "simulation/quantity.h"

#include <cmath>
#include <cstdlib>
#include <vector>

#include "base/error.h"
#include "base/units.h"

namespace mm {
namespace {

struct Unit {
  const char* name;
  const char* dimension;
  double factor;
};

// The first unit of a dimension is the one for people.
const std::vector<Unit>& units() {
  static const std::vector<Unit> list = {
      {"um", "m", 1e-6},
      {"mm", "m", 1e-3},
      {"nm", "m", 1e-9},
      {"m", "m", 1.0},
      {"arcsec", "rad", kArcsecond},
      {"deg", "rad", kDegree},
      {"mrad", "rad", 1e-3},
      {"urad", "rad", 1e-6},
      {"rad", "rad", 1.0},
      {"um/m", "rad", 1e-6},
      {"mm/m", "rad", 1e-3},
      {"deg", "turn", kDegree},
      {"rad", "turn", 1.0},
      {"um/m", "1", 1e-6},
      {"ppm", "1", 1e-6},
      {"percent", "1", 1e-2},
      {"%", "1", 1e-2},
      {"1", "1", 1.0},
      {"", "1", 1.0},
      {"s", "s", 1.0},
      {"ms", "s", 1e-3},
      {"min", "s", 60.0},
      {"h", "s", 3600.0},
      {"um/h", "m/s", 1e-6 / 3600.0},
      {"um/min", "m/s", 1e-6 / 60.0},
      {"m/s", "m/s", 1.0},
      {"um/K", "m/K", 1e-6},
      {"m/K", "m/K", 1.0},
      {"arcsec/K", "rad/K", kArcsecond},
      {"urad/K", "rad/K", 1e-6},
      {"rad/K", "rad/K", 1.0},
      {"ppm/K", "1/K", 1e-6},
      {"um/m/K", "1/K", 1e-6},
      {"1/K", "1/K", 1.0},
      {"1/m", "1/m", 1.0},
      {"share", "share", 1.0},
      {"", "share", 1.0},
      {"mm", "length", 1e-3},
      {"um", "length", 1e-6},
      {"m", "length", 1.0},
      {"mm/s", "speed", 1e-3},
      {"m/s", "speed", 1.0},
  };
  return list;
}

}  // namespace

double parseQuantity(const std::string& text, const std::string& dimension, const std::string& where) {
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  std::string unit(end);
  unit.erase(0, unit.find_first_not_of(" _"));
  while (!unit.empty() && unit.back() == ' ') unit.pop_back();
  std::string fitting;
  for (const Unit& u : units()) {
    if (dimension != u.dimension) continue;
    if (end != text.c_str() && std::isfinite(number) && unit == u.name) return number * u.factor;
    if (*u.name != '\0') fitting += (fitting.empty() ? "" : ", ") + std::string(u.name);
  }
  throw InputError(where + ": '" + text + "' is not a number with a unit of " + fitting);
}

PeopleUnit peopleUnit(const std::string& dimension) {
  for (const Unit& u : units())
    if (dimension == u.dimension) return {u.name, u.factor};
  return {dimension, 1.0};
}

}  // namespace mm
