// Uncatalogued effects of the structure and the drives, each by its physics.
#include "simulation/uncatalogued_kinds.h"

#include <cmath>

namespace mm {
namespace uncatalogued {

Kinds structure() {
  return {
      {"uncatalogued_guide_load",
       "the carriage loads its guide the more, the farther out on its beam it stands",
       Along::kThird,
       {kAxis, kAcross},
       {},
       {"[axis]", "[across]"},
       [](const Setting& s) { return s.place("axis") * s.place("across"); }},
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
      {"uncatalogued_loose_nut",
       "the bridge bends over the worn middle of its cross rail and eases the nut there: it has play",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {{"place", "share", 0.05, 0.4, true}, {"width", "share", 0.25, 0.45}},
       {"[axis] travel direction", "[across]"},
       [](const Setting& s) -> Quantity {
         return [side = s.side("axis"), w = s.place("across"), at = s.number("place"),
                 width = s.number("width")](const Condition& c) {
           const double away = (w(c) - at) / width;
           return side(c) * std::exp(-0.5 * away * away);
         };
       }},
      {"uncatalogued_warm_nut",
       "the nut, preloaded when it was cool, gains play as it warms",
       Along::kOwnAxis,
       {kLevelAxis, kSensor},
       {},
       {"[axis] travel direction", "temperature [sensor]"},
       [](const Setting& s) { return s.side("axis") * s.warmth("sensor"); }},
      {"uncatalogued_friction_lever",
       "friction drags the carriage askew, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {},
       {"[axis] travel direction", "[across]"},
       [](const Setting& s) { return s.side("axis") * s.place("across"); }},
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
       [](const Setting& s) { return s.side("axis"); }},
      {"uncatalogued_drive_yaw",
       "viscous drag beside the drive turns the carriage, with the arm at which the tip stands",
       Along::kOwnAxis,
       {kLevelAxis, kAcross},
       {},
       {"[axis] speed", "[across]"},
       [](const Setting& s) { return s.velocity("axis") * s.place("across"); }},
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

}  // namespace uncatalogued

const std::vector<UncataloguedKind>& uncataloguedKinds() {
  static const uncatalogued::Kinds kinds = [] {
    uncatalogued::Kinds all;
    for (const uncatalogued::Kinds& group :
         {uncatalogued::structure(), uncatalogued::friction(), uncatalogued::heat(), uncatalogued::moments(),
          uncatalogued::probe()})
      all.insert(all.end(), group.begin(), group.end());
    return all;
  }();
  return kinds;
}

}  // namespace mm
