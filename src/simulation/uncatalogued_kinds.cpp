// The kinds of uncatalogued effects, each by its physics.
#include <algorithm>
#include <cmath>

#include "machine/units.h"
#include "simulation/uncatalogued.h"

namespace mm {
namespace {

using Along = UncataloguedKind::Along;
using Key = SourceKind::Key;
using Kinds = std::vector<UncataloguedKind>;

const SourceKind::KeyRule kAxis = {"axis", Key::kLinear, ""}, kLevelAxis = {"axis", Key::kLevel, ""},
                          kAcross = {"across", Key::kOtherLinear, ""},
                          kSideways = {"direction", Key::kOtherDirection, ""},
                          kAnywhere = {"direction", Key::kDirection, ""},
                          kSensor = {"sensor", Key::kBody, ""}, kWarm = {"warm", Key::kBody, ""},
                          kCold = {"cold", Key::kColdBody, ""}, kDamp = {"covariate", Key::kCovariate, ""};
const SourceKind::NumberRule kPhase = {"phase", "turn", 0.01, 6.28};

double turns(double part) { return 2.0 * kPi * part; }

/// 0 long before, 1 long after `at`.
double step(double value, double at, double width) { return 0.5 + 0.5 * std::tanh((value - at) / width); }

Kinds structure() {
  return {
      {"uncatalogued_guide_load",
       "the carriage loads its guide the more, the farther out on its beam it stands",
       Along::kThird,
       {kAxis, kAcross},
       {},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), w = s.place("across")](const Condition& c) { return u(c) * w(c); };
       }},
      {"uncatalogued_table_sag",
       "a table on two supports sags under a mass that travels between them and leans over to one side",
       Along::kThird,
       {kAxis, kAcross},
       {},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), w = s.place("across")](const Condition& c) {
           const double a = 1.0 - 0.9 * u(c), b = 1.0 + 0.9 * u(c);  // distances to the supports
           return a * a * b * b * (0.5 + 0.5 * w(c));
         };
       }},
      {"uncatalogued_plate_seam",
       "the table is made of two plates that meet at an angle along a slanting seam",
       Along::kThird,
       {kAxis, kAcross},
       {{"angle", "turn", 25.0 * kDegree, 65.0 * kDegree, true},
        {"seam", "length", 0.5e-3, 5e-3, true},
        {"rounding", "length", 0.5e-3, 2e-3}},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         const double cosine = std::cos(s.number("angle")), sine = std::sin(s.number("angle"));
         return [=, q = s.position("axis"), r = s.position("across"), at = s.number("seam"),
                 edge = s.number("rounding")](const Condition& c) {
           return std::hypot(cosine * q(c) + sine * r(c) - at, edge);
         };
       }},
      {"uncatalogued_diagonal_ribs",
       "the table's diagonal ribs show through its surface",
       Along::kThird,
       {kAxis, kAcross},
       {{"pitch", "length", 9e-3, 16e-3}, kPhase, {"slope", "share", 1.0, 1.0, true}},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         return [q = s.position("axis"), r = s.position("across"), pitch = s.number("pitch"),
                 slope = s.number("slope"), phase = s.number("phase")](const Condition& c) {
           return std::cos(turns((q(c) + slope * r(c)) / pitch) + phase);
         };
       }},
      {"uncatalogued_rail_bolts",
       "the rail is drawn down where it is bolted",
       Along::kDirection,
       {kAxis, kSideways},
       {{"pitch", "length", 6e-3, 10e-3}, kPhase},
       {"[axis]"},
       [](const Setting& s) -> Quantity {
         return [q = s.position("axis"), pitch = s.number("pitch"), phase = s.number("phase")](
                    const Condition& c) { return std::exp(1.5 * std::cos(turns(q(c) / pitch) + phase)); };
       }},
      {"uncatalogued_growing_cogging",
       "the motor's cogging reaches the tip through a yoke that is softer the farther out it stands",
       Along::kOwnAxis,
       {kAxis, kAcross},
       {{"pitch", "length", 1.2e-3, 2.6e-3}, kPhase},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         return [q = s.position("axis"), w = s.place("across"), pitch = s.number("pitch"),
                 phase = s.number("phase")](const Condition& c) {
           return std::sin(turns(q(c) / pitch) + phase) * std::exp(1.2 * w(c));
         };
       }},
      {"uncatalogued_end_stop_warp",
       "the bridge warps as it runs up against its end stop",
       Along::kThird,
       {kAxis, kAcross},
       {{"reach", "share", 0.2, 0.5}},
       {"[axis]", "[across]"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), w = s.place("across"), reach = s.number("reach")](const Condition& c) {
           return std::exp((u(c) - 1.0) / reach) * w(c);
         };
       }},
  };
}

Kinds friction() {
  return {
      {"uncatalogued_worn_screw",
       "the screw is worn where it is used most, and the nut has play there",
       Along::kOwnAxis,
       {kLevelAxis},
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.25, 0.45}},
       {"[axis]", "[axis] travel direction"},
       [](const Setting& s) -> Quantity {
         return [u = s.place("axis"), side = s.side("axis"), at = s.number("place"),
                 width = s.number("width")](const Condition& c) {
           const double away = (u(c) - at) / width;
           return side(c) * std::exp(-0.5 * away * away);
         };
       }},
      {"uncatalogued_friction_lever",
       "friction drags the carriage askew, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {},
       {"[axis] travel direction", "[across]"},
       [](const Setting& s) -> Quantity {
         return [side = s.side("axis"), w = s.place("across")](const Condition& c) { return side(c) * w(c); };
       }},
      {"uncatalogued_stick_slip",
       "dry friction winds the drive up at low speed and lets go at higher (Stribeck)",
       Along::kOwnAxis,
       {kLevelAxis},
       {{"knee", "speed", 0.6e-3, 1.5e-3}},
       {"[axis] speed"},
       [](const Setting& s) -> Quantity {
         return [v = s.velocity("axis"), side = s.side("axis"), knee = s.number("knee")](const Condition& c) {
           return side(c) * std::exp(-std::pow(v(c) / knee, 2));
         };
       }},
      {"uncatalogued_hydrodynamic_film",
       "the carriage floats up on its oil film with speed",
       Along::kDirection,
       {kLevelAxis, kSideways},
       {},
       {"[axis] speed"},
       [](const Setting& s) -> Quantity {
         return [v = s.velocity("axis")](const Condition& c) { return std::sqrt(std::abs(v(c))); };
       }},
      {"uncatalogued_reversal_heave",
       "the carriage tips in its guide at reversal and lifts or turns aside",
       Along::kDirection,
       {kLevelAxis, kSideways},
       {},
       {"[axis] travel direction"},
       [](const Setting& s) -> Quantity { return s.side("axis"); }},
      {"uncatalogued_drive_yaw",
       "viscous drag beside the drive turns the carriage, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {},
       {"[axis] speed", "[across]"},
       [](const Setting& s) -> Quantity {
         return [v = s.velocity("axis"), w = s.place("across")](const Condition& c) { return v(c) * w(c); };
       }},
      {"uncatalogued_grease_drag",
       "the grease thins as it warms, and the drive lags less",
       Along::kOwnAxis,
       {kLevelAxis, kSensor},
       {},
       {"[axis] speed", "temperature [sensor]"},
       [](const Setting& s) -> Quantity {
         return [v = s.velocity("axis"), warmth = s.warmth("sensor")](const Condition& c) {
           return v(c) * (std::exp(-0.2 * warmth(c)) - 1.0);
         };
       }},
  };
}

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
       [](const Setting& s) -> Quantity {
         return [warmth = s.warmth("sensor")](const Condition& c) { return warmth(c) * warmth(c); };
       }},
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
       [](const Setting& s) -> Quantity {
         return [warmth = s.warmth("sensor"), damp = s.moisture("covariate")](const Condition& c) {
           return warmth(c) * damp(c);
         };
       }},
      {"uncatalogued_swollen_granite",
       "granite swells once more moisture is about than its seal keeps out",
       Along::kDirection,
       {kAnywhere, kDamp},
       {},
       {"[covariate]"},
       [](const Setting& s) -> Quantity {
         return [damp = s.moisture("covariate")](const Condition& c) { return damp(c) * damp(c); };
       }},
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
         return [slant = s.slant(), slender = s.number("slenderness")](const Condition& c) {
           const double sideways = slant(c) * slant(c);
           return sideways * (1.0 + slender * sideways);
         };
       }},
      {"uncatalogued_warm_probe",
       "the probe's spring softens with heat, and it trips later",
       Along::kApproach,
       {kSensor},
       {},
       {"temperature [sensor]"},
       [](const Setting& s) -> Quantity { return s.warmth("sensor"); }},
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

}  // namespace

const Kinds& uncataloguedKinds() {
  static const Kinds kinds = [] {
    Kinds all;
    for (const Kinds& group : {structure(), friction(), heat(), moments(), probe()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return kinds;
}

}  // namespace mm
