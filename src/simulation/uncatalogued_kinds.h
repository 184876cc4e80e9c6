#pragma once
#include "base/units.h"
#include "simulation/uncatalogued.h"

// For the sources of the kinds only.
namespace mm::uncatalogued {

using Along = UncataloguedKind::Along;
using Key = SourceKind::Key;
using Kinds = std::vector<UncataloguedKind>;

Kinds structure();  ///< of the guides and the table: positions
Kinds friction();   ///< of the drives: speed and direction of travel
Kinds heat();       ///< temperatures and moisture
Kinds moments();    ///< what happens in the course of time
Kinds probe();      ///< along the approach

inline const SourceKind::KeyRule kAxis = {"axis", Key::kLinear, ""}, kLevelAxis = {"axis", Key::kLevel, ""},
                                 kAcross = {"across", Key::kOtherLinear, ""},
                                 kSideways = {"direction", Key::kOtherDirection, ""},
                                 kAnywhere = {"direction", Key::kDirection, ""},
                                 kSensor = {"sensor", Key::kBody, ""}, kWarm = {"warm", Key::kBody, ""},
                                 kCold = {"cold", Key::kColdBody, ""},
                                 kDamp = {"covariate", Key::kCovariate, ""};
inline const SourceKind::NumberRule kPhase = {"phase", "turn", 0.01, 6.28};

/// The product of two quantities.
inline Quantity operator*(Quantity a, Quantity b) {
  return [a = std::move(a), b = std::move(b)](const Condition& c) { return a(c) * b(c); };
}
/// Radians of a part of a turn.
inline double turns(double part) { return 2.0 * kPi * part; }

}  // namespace mm::uncatalogued
