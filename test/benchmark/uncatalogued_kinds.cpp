// Uncatalogued effects, each by its physics.
#include <algorithm>
#include <cmath>

#include "base/units.h"
#include "uncatalogued.h"

namespace mm {
namespace {

using Along = UncataloguedKind::Along;
using Key = SourceKind::Key;

const SourceKind::KeyRule kAxis = {"axis", Key::kLinear, ""}, kLevelAxis = {"axis", Key::kLevel, ""},
                          kAcross = {"across", Key::kOtherLinear, ""},
                          kSideways = {"direction", Key::kOtherDirection, ""},
                          kAnywhere = {"direction", Key::kDirection, ""},
                          kSensor = {"sensor", Key::kBody, ""}, kWarm = {"warm", Key::kBody, ""},
                          kCold = {"cold", Key::kColdBody, ""}, kDamp = {"covariate", Key::kCovariate, ""};
const SourceKind::NumberRule kPhase = {"phase", "turn", 0.01, 6.28};

/// Radians of a wave at a place or a time. @param period the number that says how long it is.
double phaseAt(const VisitedInstant& i, double at, const char* period) {
  return 2.0 * kPi * (at / i.number(period)) + i.number("phase");
}

/// 0 long before, 1 long after `at`.
double step(double value, double at, double width) { return 0.5 + 0.5 * std::tanh((value - at) / width); }

}  // namespace

const std::vector<UncataloguedKind>& uncataloguedKinds() {
  static const std::vector<UncataloguedKind> kinds = {
      // of the guides and the table: positions
      {"uncatalogued_guide_load",
       "the carriage loads its guide the more, the farther out on its beam it stands",
       Along::kThird,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) { return i.place("axis") * i.place("across"); }},
      {"uncatalogued_table_sag",
       "a table on two supports sags under a mass that travels between them and leans over to one side",
       Along::kThird,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) {
         const double u = i.place("axis");
         const double a = 1.0 - 0.9 * u, b = 1.0 + 0.9 * u;  // distances to the supports
         return a * a * b * b * (0.5 + 0.5 * i.place("across"));
       }},
      {"uncatalogued_plate_seam",
       "the table is made of two plates that meet at an angle along a slanting seam",
       Along::kThird,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) {
         const double cosine = std::cos(i.number("angle")), sine = std::sin(i.number("angle"));
         return std::hypot(cosine * i.position("axis") + sine * i.position("across") - i.number("seam"),
                           i.number("rounding"));
       },
       {{"angle", "turn", 25.0 * kDegree, 65.0 * kDegree, true},
        {"seam", "length", 0.5e-3, 5e-3, true},
        {"rounding", "length", 0.5e-3, 2e-3}}},
      {"uncatalogued_diagonal_ribs",
       "the table's diagonal ribs show through its surface",
       Along::kThird,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) {
         return std::cos(phaseAt(i, i.position("axis") + i.number("slope") * i.position("across"), "pitch"));
       },
       {{"pitch", "length", 9e-3, 16e-3}, kPhase, {"slope", "share", 1.0, 1.0, true}}},
      {"uncatalogued_rail_bolts",
       "the rail is drawn down where it is bolted",
       Along::kDirection,
       {kAxis, kSideways},
       {"[axis]"},
       [](const VisitedInstant& i) {
         return std::exp(1.5 * std::cos(phaseAt(i, i.position("axis"), "pitch")));
       },
       {{"pitch", "length", 6e-3, 10e-3}, kPhase}},
      {"uncatalogued_growing_cogging",
       "the motor's cogging reaches the tip through a yoke that is softer the farther out it stands",
       Along::kOwnAxis,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) {
         return std::sin(phaseAt(i, i.position("axis"), "pitch")) * std::exp(1.2 * i.place("across"));
       },
       {{"pitch", "length", 1.2e-3, 2.6e-3}, kPhase}},
      {"uncatalogued_end_stop_warp",
       "the bridge warps as it runs up against its end stop",
       Along::kThird,
       {kAxis, kAcross},
       {"[axis]", "[across]"},
       [](const VisitedInstant& i) {
         return std::exp((i.place("axis") - 1.0) / i.number("reach")) * i.place("across");
       },
       {{"reach", "share", 0.2, 0.5}}},

      // of the drives: speed and direction of travel
      {"uncatalogued_loose_nut",
       "the bridge bends over the worn middle of its cross rail and eases the nut there: it has play",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {"[axis] travel direction", "[across]"},
       [](const VisitedInstant& i) {
         const double away = (i.place("across") - i.number("place")) / i.number("width");
         return i.side("axis") * std::exp(-0.5 * away * away);
       },
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.25, 0.45}}},
      {"uncatalogued_warm_nut",
       "the nut, preloaded when it was cool, gains play as it warms",
       Along::kOwnAxis,
       {kLevelAxis, kSensor},
       {"[axis] travel direction", "temperature [sensor]"},
       [](const VisitedInstant& i) { return i.side("axis") * i.warmth("sensor"); }},
      {"uncatalogued_friction_lever",
       "friction drags the carriage askew, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {"[axis] travel direction", "[across]"},
       [](const VisitedInstant& i) { return i.side("axis") * i.place("across"); }},
      {"uncatalogued_stick_slip",
       "dry friction winds the drive up at low speed and lets go at higher (Stribeck)",
       Along::kOwnAxis,
       {kLevelAxis},
       {"[axis] speed"},
       [](const VisitedInstant& i) {
         return i.side("axis") * std::exp(-std::pow(i.velocity("axis") / i.number("knee"), 2));
       },
       {{"knee", "speed", 0.6e-3, 1.5e-3}}},
      {"uncatalogued_hydrodynamic_film",
       "the carriage floats up on its oil film with speed",
       Along::kDirection,
       {kLevelAxis, kSideways},
       {"[axis] speed"},
       [](const VisitedInstant& i) { return std::sqrt(std::abs(i.velocity("axis"))); }},
      {"uncatalogued_drive_yaw",
       "viscous drag beside the drive turns the carriage, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {"[axis] speed", "[across]"},
       [](const VisitedInstant& i) { return i.velocity("axis") * i.place("across"); }},
      {"uncatalogued_grease_drag",
       "the grease thins as it warms, and the drive lags less",
       Along::kOwnAxis,
       {kLevelAxis, kSensor},
       {"[axis] speed", "temperature [sensor]"},
       [](const VisitedInstant& i) {
         return i.velocity("axis") * (std::exp(-0.2 * i.warmth("sensor")) - 1.0);
       }},

      // temperatures and moisture
      {"uncatalogued_cold_cable_chain",
       "the cable chain pulls to the side where it bends over, harder in the cold",
       Along::kDirection,
       {kAxis, kSideways, kSensor},
       {"[axis]", "temperature [sensor]"},
       [](const VisitedInstant& i) {
         return std::tanh((i.place("axis") - i.number("place")) / i.number("width")) * i.warmth("sensor");
       },
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.15, 0.4}}},
      {"uncatalogued_bed_bow",
       "a bed warmer on one face than on the other bows",
       Along::kDirection,
       {kAxis, kSideways, kWarm, kCold},
       {"[axis]", "temperature [warm]", "temperature [cold]"},
       [](const VisitedInstant& i) {
         return (i.warmth("warm") - i.warmth("cold")) * (1.0 - i.place("axis") * i.place("axis"));
       }},
      {"uncatalogued_invar_curve",
       "a part of invar has its least length at one temperature and grows to both sides of it",
       Along::kDirection,
       {kAnywhere, kSensor},
       {"temperature [sensor]"},
       [](const VisitedInstant& i) { return i.warmth("sensor") * i.warmth("sensor"); }},
      {"uncatalogued_hot_creep",
       "a glued joint gives way with time and yields to heat the more it has",
       Along::kDirection,
       {kAnywhere, kSensor},
       {"temperature [sensor]", "time"},
       [](const VisitedInstant& i) { return i.warmth("sensor") * (i.now.time / i.duration() - 0.5); }},
      {"uncatalogued_damp_warmth",
       "a polymer part swells with moisture when it is warm",
       Along::kDirection,
       {kAnywhere, kSensor, kDamp},
       {"temperature [sensor]", "[covariate]"},
       [](const VisitedInstant& i) { return i.warmth("sensor") * i.moisture("covariate"); }},
      {"uncatalogued_swollen_granite",
       "granite swells once more moisture is about than its seal keeps out",
       Along::kDirection,
       {kAnywhere, kDamp},
       {"[covariate]"},
       [](const VisitedInstant& i) { return i.moisture("covariate") * i.moisture("covariate"); }},
      {"uncatalogued_damp_bow",
       "a granite table takes up moisture at its face and bows",
       Along::kDirection,
       {kAxis, kSideways, kDamp},
       {"[axis]", "[covariate]"},
       [](const VisitedInstant& i) {
         return i.moisture("covariate") * (1.0 - i.place("axis") * i.place("axis"));
       }},

      // what happens in the course of time
      {"uncatalogued_floor_oscillation",
       "the floor moves with a machine next door that runs in cycles",
       Along::kDirection,
       {kAnywhere},
       {"time"},
       [](const VisitedInstant& i) { return std::sin(phaseAt(i, i.now.time, "period")); },
       {{"period", "s", 300.0, 1100.0}, kPhase}},
      {"uncatalogued_rocking_floor",
       "the floor rocks in cycles, and the table with it",
       Along::kDirection,
       {kAxis, kSideways},
       {"[axis]", "time"},
       [](const VisitedInstant& i) { return i.place("axis") * std::sin(phaseAt(i, i.now.time, "period")); },
       {{"period", "s", 400.0, 1200.0}, kPhase}},
      {"uncatalogued_thermal_shock",
       "a door was opened: a cold draught, then a slow recovery",
       Along::kDirection,
       {kAnywhere},
       {"time"},
       [](const VisitedInstant& i) {
         constexpr double kDraught = 30.0;  // s
         const double since = i.now.time - i.number("moment") * i.duration();
         return since <= 0.0 ? 0.0
                             : (1.0 - std::exp(-since / kDraught)) * std::exp(-since / i.number("recovery"));
       },
       {{"moment", "share", 0.25, 0.6}, {"recovery", "s", 300.0, 900.0}}},
      {"uncatalogued_slipping_plate",
       "a clamp let go at one moment, and the plate turned",
       Along::kDirection,
       {kAxis, kSideways},
       {"[axis]", "time"},
       [](const VisitedInstant& i) {
         return i.place("axis") * step(i.now.time, i.number("moment") * i.duration(), 10.0);
       },
       {{"moment", "share", 0.3, 0.7}}},

      // along the approach
      {"uncatalogued_cable_drag",
       "the probe's cable hangs over beyond a point and its drag delays the trigger",
       Along::kApproach,
       {kAxis},
       {"[axis]"},
       [](const VisitedInstant& i) { return step(i.place("axis"), i.number("place"), i.number("width")); },
       {{"place", "share", 0.05, 0.3, true}, {"width", "share", 0.05, 0.15}}},
      {"uncatalogued_taut_cable",
       "the probe's cable is slack up to a point and pulls on the stylus beyond it",
       Along::kApproach,
       {kAxis},
       {"[axis]"},
       [](const VisitedInstant& i) {
         return i.number("width") *
                std::log1p(std::exp((i.place("axis") - i.number("place")) / i.number("width")));
       },
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.05, 0.15}}},
      {"uncatalogued_trigger_resonance",
       "the trigger circuit rings when the probe comes at one speed",
       Along::kApproach,
       {},
       {"tip speed"},
       [](const VisitedInstant& i) {
         return 1.0 / (1.0 + std::pow((i.tipMotion().norm() - i.number("speed")) / i.number("width"), 2));
       },
       {{"speed", "speed", 2e-3, 3e-3}, {"width", "speed", 0.4e-3, 0.8e-3}}},
      {"uncatalogued_stylus_bending",
       "a long stylus bends before the probe trips, when it is pushed from the side",
       Along::kApproach,
       {},
       {"approach"},
       [](const VisitedInstant& i) {
         const double sideways = i.slant() * i.slant();
         return sideways * (1.0 + i.number("slenderness") * sideways);
       },
       {{"slenderness", "share", 0.2, 0.8}},
       true},
      {"uncatalogued_warm_probe",
       "the probe's spring softens with heat, and it trips later",
       Along::kApproach,
       {kSensor},
       {"temperature [sensor]"},
       [](const VisitedInstant& i) { return i.warmth("sensor"); }},
      {"uncatalogued_worn_tip",
       "the tip wears off, quickly at first",
       Along::kApproach,
       {},
       {"time"},
       [](const VisitedInstant& i) {
         return std::pow(std::max(0.0, i.now.time / i.duration()), i.number("exponent"));
       },
       {{"exponent", "share", 0.5, 0.8}}},
  };
  return kinds;
}

}  // namespace mm
