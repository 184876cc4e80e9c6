// Uncatalogued effects of heat, moisture, time and of the probe, each by its physics.
#include <algorithm>
#include <cmath>

#include "simulation/uncatalogued_kinds.h"

namespace mm::uncatalogued {
namespace {

/// 0 long before, 1 long after `at`.
double step(double value, double at, double width) { return 0.5 + 0.5 * std::tanh((value - at) / width); }

}  // namespace

Kinds heat() {
  return {
      {"uncatalogued_cold_cable_chain",
       "the cable chain pulls to the side where it bends over, harder in the cold",
       Along::kDirection,
       {kAxis, kSideways, kSensor},
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.15, 0.4}},
       {"[axis]", "temperature [sensor]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), warmth = s.warmth("sensor"), at = s.number("place"),
                 width = s.number("width")](const Condition& c) {
           return std::tanh((u(c) - at) / width) * warmth(c);
         };
       }},
      {"uncatalogued_bed_bow",
       "a bed warmer on one face than on the other bows",
       Along::kDirection,
       {kAxis, kSideways, kWarm, kCold},
       {},
       {"[axis]", "temperature [warm]", "temperature [cold]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), warm = s.warmth("warm"), cold = s.warmth("cold")](const Condition& c) {
           return (warm(c) - cold(c)) * (1.0 - u(c) * u(c));
         };
       }},
      {"uncatalogued_invar_curve",
       "a part of invar has its least length at one temperature and grows to both sides of it",
       Along::kDirection,
       {kAnywhere, kSensor},
       {},
       {"temperature [sensor]"},
       [](const Setting& s) { return s.warmth("sensor") * s.warmth("sensor"); }},
      {"uncatalogued_hot_creep",
       "a glued joint gives way with time and yields to heat the more it has",
       Along::kDirection,
       {kAnywhere, kSensor},
       {},
       {"temperature [sensor]", "time"},
       [](const Setting& s) -> Quantity {
         return [warmth = s.warmth("sensor"), end = s.duration()](const Condition& c) {
           return warmth(c) * (c.time / end - 0.5);
         };
       }},
      {"uncatalogued_damp_warmth",
       "a polymer part swells with moisture when it is warm",
       Along::kDirection,
       {kAnywhere, kSensor, kDamp},
       {},
       {"temperature [sensor]", "[covariate]"},
       [](const Setting& s) { return s.warmth("sensor") * s.moisture("covariate"); }},
      {"uncatalogued_swollen_granite",
       "granite swells once more moisture is about than its seal keeps out",
       Along::kDirection,
       {kAnywhere, kDamp},
       {},
       {"[covariate]"},
       [](const Setting& s) { return s.moisture("covariate") * s.moisture("covariate"); }},
      {"uncatalogued_damp_bow",
       "a granite table takes up moisture at its face and bows",
       Along::kDirection,
       {kAxis, kSideways, kDamp},
       {},
       {"[axis]", "[covariate]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), damp = s.moisture("covariate")](const Condition& c) {
           return damp(c) * (1.0 - u(c) * u(c));
         };
       }},
  };
}

Kinds moments() {
  return {
      {"uncatalogued_floor_oscillation",
       "the floor moves with a machine next door that runs in cycles",
       Along::kDirection,
       {kAnywhere},
       {{"period", "s", 300.0, 1100.0}, kPhase},
       {"time"},
       [](const Setting& s) -> Quantity {
         return [period = s.number("period"), phase = s.number("phase")](const Condition& c) {
           return std::sin(turns(c.time / period) + phase);
         };
       }},
      {"uncatalogued_rocking_floor",
       "the floor rocks in cycles, and the table with it",
       Along::kDirection,
       {kAxis, kSideways},
       {{"period", "s", 400.0, 1200.0}, kPhase},
       {"[axis]", "time"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), period = s.number("period"), phase = s.number("phase")](
                    const Condition& c) { return u(c) * std::sin(turns(c.time / period) + phase); };
       }},
      {"uncatalogued_thermal_shock",
       "a door was opened: a cold draught, then a slow recovery",
       Along::kDirection,
       {kAnywhere},
       {{"moment", "share", 0.25, 0.6}, {"recovery", "s", 300.0, 900.0}},
       {"time"},
       [](const Setting& s) -> Quantity {
         return
             [at = s.number("moment") * s.duration(), recovery = s.number("recovery")](const Condition& c) {
               constexpr double kDraught = 30.0;  // s
               const double since = c.time - at;
               return since <= 0.0 ? 0.0 : (1.0 - std::exp(-since / kDraught)) * std::exp(-since / recovery);
             };
       }},
      {"uncatalogued_slipping_plate",
       "a clamp let go at one moment, and the plate turned",
       Along::kDirection,
       {kAxis, kSideways},
       {{"moment", "share", 0.3, 0.7}},
       {"[axis]", "time"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), at = s.number("moment") * s.duration()](const Condition& c) {
           return u(c) * step(c.time, at, 10.0);
         };
       }},
  };
}

Kinds probe() {
  return {
      {"uncatalogued_cable_drag",
       "the probe's cable hangs over beyond a point and its drag delays the trigger",
       Along::kApproach,
       {kAxis},
       {{"place", "share", 0.05, 0.3, true}, {"width", "share", 0.05, 0.15}},
       {"[axis]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), at = s.number("place"), width = s.number("width")](const Condition& c) {
           return step(u(c), at, width);
         };
       }},
      {"uncatalogued_taut_cable",
       "the probe's cable is slack up to a point and pulls on the stylus beyond it",
       Along::kApproach,
       {kAxis},
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.05, 0.15}},
       {"[axis]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), at = s.number("place"), width = s.number("width")](const Condition& c) {
           return width * std::log1p(std::exp((u(c) - at) / width));
         };
       }},
      {"uncatalogued_trigger_resonance",
       "the trigger circuit rings when the probe comes at one speed",
       Along::kApproach,
       {},
       {{"speed", "speed", 2e-3, 3e-3}, {"width", "speed", 0.4e-3, 0.8e-3}},
       {"tip speed"},
       [](const Setting& s) -> Quantity {
         return [speed = s.tipSpeed(), at = s.number("speed"), width = s.number("width")](
                    const Condition& c) { return 1.0 / (1.0 + std::pow((speed(c) - at) / width, 2)); };
       }},
      {"uncatalogued_stylus_bending",
       "a long stylus bends before the probe trips, when it is pushed from the side",
       Along::kApproach,
       {},
       {{"slenderness", "share", 0.2, 0.8}},
       {"approach"},
       [](const Setting& s) -> Quantity {
         return s.qualified([slant = s.slant(), slender = s.number("slenderness")](const Condition& c) {
           const double sideways = slant(c) * slant(c);
           return sideways * (1.0 + slender * sideways);
         });
       }},
      {"uncatalogued_warm_probe",
       "the probe's spring softens with heat, and it trips later",
       Along::kApproach,
       {kSensor},
       {},
       {"temperature [sensor]"},
       [](const Setting& s) { return s.warmth("sensor"); }},
      {"uncatalogued_worn_tip",
       "the tip wears off, quickly at first",
       Along::kApproach,
       {},
       {{"exponent", "share", 0.5, 0.8}},
       {"time"},
       [](const Setting& s) -> Quantity {
         return [end = s.duration(), exponent = s.number("exponent")](const Condition& c) {
           return std::pow(std::max(0.0, c.time / end), exponent);
         };
       }},
  };
}

}  // namespace mm::uncatalogued
