#pragma once
#include <string>

#include "base/units.h"
#include "effects/effect.h"

namespace mm {

/// A unit that people read: value in it = SI value * toUnit.
struct Unit {
  std::string name;
  double toUnit = 1.0;
};

inline const Unit kUnitMicrometre{"um", 1e6};
inline const Unit kUnitArcsecond{"arcsec", 1.0 / kArcsecond};
inline const Unit kUnitMillimetre{"mm", 1e3};
inline const Unit kUnitMetre{"m", 1.0};
inline const Unit kUnitDegree{"deg", 1.0 / kDegree};
inline const Unit kUnitKelvin{"K", 1.0};
inline const Unit kUnitHour{"h", 1.0 / 3600.0};

inline Unit operator/(const Unit& a, const Unit& b) { return {a.name + "/" + b.name, a.toUnit / b.toUnit}; }

/// um or arcsec: the unit of a small error along a joint of this kind.
inline const Unit& errorUnit(JointKind kind) {
  return kind == JointKind::kLinear ? kUnitMicrometre : kUnitArcsecond;
}
/// m or deg: the unit of a reading below a fraction line.
inline const Unit& readingUnit(JointKind kind) {
  return kind == JointKind::kLinear ? kUnitMetre : kUnitDegree;
}

/// scale, bound and start in SI.
inline Parameter parameter(const std::string& name, const Unit& unit, double scale, double bound,
                           double start = 0.0) {
  Parameter p;
  p.name = name;
  p.unit = unit.name;
  p.toUnit = unit.toUnit;
  p.scale = scale;
  p.bound = bound;
  p.start = start;
  return p;
}

/// A coefficient of thermal expansion, of lengths or of the unit given. Parts that carry positions are of
/// steel (11.5e-6/K), granite (6), glass (8), aluminium (23), carbon fibre or Zerodur (0): 1.3e-5/K in the
/// root mean square. Zinc has 30e-6/K, few plastics more than 100e-6/K.
inline Parameter expansionParameter(const Unit& unit) {
  Parameter p = parameter("expansion", unit, 1e-5, 1e-3);
  p.usual = 1.3e-5;
  return p;
}

/// A small error along a joint or direction: um up to 1 mm, arcsec up to 0.02 rad.
inline Parameter errorParameter(const std::string& name, JointKind kind) {
  return kind == JointKind::kLinear ? parameter(name, kUnitMicrometre, 1e-6, 1e-3)
                                    : parameter(name, kUnitArcsecond, kArcsecond, 0.02);
}

/// A small error of one kind per reading of another: um/m up to 0.02, arcsec/deg …
inline Parameter slopeParameter(const std::string& name, JointKind error, JointKind reading) {
  const bool same = error == reading;
  const double bound = same ? 0.02 : error == JointKind::kLinear ? 0.01 : 1.0;
  return parameter(name, errorUnit(error) / readingUnit(reading), same ? 1e-4 : 1e-2 * bound, bound);
}

}  // namespace mm
