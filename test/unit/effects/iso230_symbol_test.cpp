// Symbols derived by hand from ISO 230-1:2012, 3.4: E, direction of the error, axis that moves; of the place
// and orientation of an axis average line: direction, 0, axis.
#include "effects/iso230_symbol.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "effects_support.h"
#include "machine_chains.h"

namespace mm {
namespace {

struct Named {
  std::string effect, symbol;
};

void expectSymbols(const Machine& machine, const std::vector<Named>& table) {
  const ErrorSymbols symbols(machine);
  const Domain domain = domainOverTravel(machine);
  for (const Named& row : table) {
    const EffectSpec spec = specOf(row.effect);
    EXPECT_EQ(symbols.of(spec), row.symbol) << machine.name() << " " << row.effect;
    EXPECT_EQ(symbols.of(createEffect(spec, domain)->spec()), row.symbol)
        << "in canonical form " << row.effect;
  }
}

TEST(ErrorSymbols, OfThreeLinearAxes) {
  expectSymbols(Machine::load("three_axis"),
                {{"{type: scale, axis: x}", "EXX"},
                 {"{type: positioning_polynomial, axis: y, degree: 3}", "EYY"},
                 {"{type: lead_screw_periodic, axis: z, period_mm: 2}", "EZZ"},
                 {"{type: backlash, axis: x}", "EXX"},
                 {"{type: lost_motion, axis: y}", "EYY"},
                 {"{type: straightness, axis: x, direction: y, degree: 2}", "EYX"},
                 {"{type: straightness, axis: z, direction: x, degree: 4}", "EXZ"},
                 {"{type: straightness_table, axis: y, direction: z}", "EZY"},
                 {"{type: position_table, axis: z}", "EZZ"},
                 {"{type: angular_motion, axis: x, about: x}", "EAX"},
                 {"{type: angular_motion, axis: x, about: y, degree: 2}", "EBX"},
                 {"{type: angular_reversal, axis: y, about: z}", "ECY"},
                 {"{type: straightness_reversal, axis: x, direction: z}", "EZX"},
                 {"{type: squareness, axis: x, of: y}", "C0Y"},
                 {"{type: squareness, axis: y, of: x}", "C0X"},
                 {"{type: squareness, axis: x, of: z}", "B0Z"},
                 {"{type: squareness, axis: y, of: z}", "A0Z"},
                 {"{type: squareness, axis: z, of: y}", "A0Y"},
                 {"{type: gravity_sag, direction: z, with: y, power: 2}", "EZY"},
                 {"{type: profile, direction: x, variable: x}", "EXX"},
                 {"{type: profile, direction: z, variable: y}", "EZY"}});
}

TEST(ErrorSymbols, AJointThatTurnsAboutZIsCWhateverItIsCalled) {
  expectSymbols(Machine::load("five_axis"),
                {{"{type: scale, axis: b}", "ECC"},
                 {"{type: backlash, axis: a}", "EAA"},
                 {"{type: rotary_zero, joint: b}", "C0C"},
                 {"{type: rotary_zero, joint: a}", "A0A"},
                 {"{type: rotary_axis_offset, joint: b, direction: x}", "X0C"},
                 {"{type: rotary_axis_offset, joint: b, direction: y}", "Y0C"},
                 {"{type: rotary_axis_offset, joint: a, direction: z}", "Z0A"},
                 {"{type: rotary_axis_tilt, joint: b, about: x}", "A0C"},
                 {"{type: rotary_axis_tilt, joint: a, about: y}", "B0A"},
                 {"{type: rotary_eccentricity, joint: b, harmonic: 1}", "EXC, EYC, ECC"},
                 {"{type: rotary_eccentricity, joint: b, harmonic: 1, reading_only: true}", "ECC"},
                 {"{type: rotary_wobble, joint: a, harmonic: 2}", "EBA, ECA"},
                 {"{type: straightness_reversal, axis: x, direction: z}", "EZX"},
                 {"{type: squareness, axis: x, of: y}", "C0Y"},
                 {"{type: straightness, axis: y, direction: z, degree: 2}", "EZY"}});
}

TEST(ErrorSymbols, OfATableOnATrunnion) {
  expectSymbols(test::tableTable(),
                {{"{type: scale, axis: saddle}", "EXX"},
                 {"{type: straightness, axis: column, direction: saddle, degree: 2}", "EXY"},
                 {"{type: squareness, axis: saddle, of: ram}", "B0Z"},
                 {"{type: rotary_zero, joint: trunnion}", "A0A"},
                 {"{type: rotary_axis_offset, joint: table, direction: y}", "Y0C"},
                 {"{type: rotary_axis_tilt, joint: trunnion, about: z}", "C0A"},
                 {"{type: rotary_axis_tilt, joint: table, about: y}", "B0C"},
                 {"{type: rotary_wobble, joint: table, harmonic: 1}", "EAC, EBC"}});
}

TEST(ErrorSymbols, OfAForkHeadWhoseAxesAreTurned) {
  // j5 stands in a link turned by 90 degrees about z: its x is y of the workpiece, its y is -x
  expectSymbols(test::headHead(), {{"{type: rotary_zero, joint: j5}", "A0A"},
                                   {"{type: rotary_axis_offset, joint: j5, direction: x}", "Y0A"},
                                   {"{type: rotary_axis_offset, joint: j5, direction: z}", "Z0A"},
                                   {"{type: rotary_axis_tilt, joint: j5, about: x}", "B0A"},
                                   {"{type: rotary_eccentricity, joint: j5, harmonic: 1}", "EYA, EZA, EAA"},
                                   {"{type: rotary_axis_offset, joint: j4, direction: x}", "X0C"},
                                   {"{type: scale, axis: j3}", "EZZ"},
                                   {"{type: straightness, axis: j1, direction: j3, degree: 3}", "EZX"}});
}

TEST(ErrorSymbols, OfAGantryWithASecondVerticalAxis) {
  expectSymbols(test::gantry(),
                {{"{type: scale, axis: bridge}", "EYY"},
                 {"{type: scale, axis: quill}", "EZW"},
                 {"{type: straightness, axis: quill, direction: carriage, degree: 2}", "EXW"},
                 {"{type: squareness, axis: carriage, of: bridge}", "C0Y"},
                 {"{type: squareness, axis: bridge, of: quill}", "A0W"},
                 {"{type: squareness, axis: ram, of: quill}", "EZW"},  // parallel: no squareness
                 {"{type: gravity_sag, direction: ram, with: bridge, power: 2}", "EZY"}});
}

TEST(ErrorSymbols, OfAMovingColumnBesideARotaryTable) {
  expectSymbols(test::movingColumn(), {{"{type: scale, axis: a}", "EBB"},
                                       {"{type: rotary_axis_offset, joint: a, direction: z}", "Z0B"},
                                       {"{type: rotary_axis_tilt, joint: a, about: x}", "A0B"},
                                       {"{type: straightness, axis: h, direction: v, degree: 2}", "EYX"},
                                       {"{type: squareness, axis: h, of: v}", "C0Y"},
                                       {"{type: angular_motion, axis: v, about: y}", "EBY"},
                                       {"{type: gravity_sag, direction: v, with: r, power: 3}", "EYZ"}});
}

TEST(ErrorSymbols, OfATelescope) {
  expectSymbols(test::telescope(),
                {{"{type: scale, axis: azimuth}", "ECC"},
                 {"{type: backlash, axis: elevation}", "EBB"},
                 {"{type: rotary_axis_tilt, joint: elevation, about: x}", "A0B"},
                 {"{type: rotary_axis_tilt, joint: azimuth, about: y}", "B0C"},
                 {"{type: rotary_wobble, joint: azimuth, harmonic: 1}", "EAC, EBC"},
                 {"{type: straightness, axis: elevation, direction: azimuth, degree: 2}", "ECB"},
                 // azimuth turns the axis of elevation
                 {"{type: straightness, axis: azimuth, direction: elevation, degree: 2}", ""}});
  expectSymbols(test::equatorialMount(), {{"{type: scale, axis: ha}", ""},
                                          {"{type: rotary_zero, joint: ha}", ""},
                                          {"{type: rotary_zero, joint: dec}", "A0A"}});
}

TEST(ErrorSymbols, WhatDependsOnMoreThanOneAxisHasNone) {
  const ErrorSymbols symbols(Machine::load("five_axis"));
  for (const char* effect :
       {"{type: thermal_expansion, axis: x, sensor: bed}", "{type: speed_lag}", "{type: probe_radius}",
        "{type: time_drift, direction: x}", "{type: mmt_deviation, axis: x, lead_mm: 1}",
        "{type: profile, direction: x, variable: bed}", "{type: profile, direction: z, variables: [x, y]}",
        "{type: profile, direction: approach, variable: x}", "{type: formula, direction: x, formula: k1*x}",
        "{type: covariate_scale, axis: x, covariate: load}", "{type: of_a_plugin, axis: x}"})
    EXPECT_EQ(symbols.of(specOf(effect)), "") << effect;
  EXPECT_EQ(ErrorSymbols().of(specOf("{type: scale, axis: x}")), "") << "of no machine";
}

TEST(ErrorSymbols, StandBehindTheWords) {
  const ErrorSymbols symbols(Machine::load("three_axis"));
  EXPECT_EQ(inWords(specOf("{type: squareness, axis: x, of: y}"), symbols), "squareness of y to x (C0Y)");
  EXPECT_EQ(inWords(specOf("{type: probe_radius}"), symbols), "effective radius of the probe tip");
}

/// The angle by which the axis `of` is turned about the axis of the symbol displaces the probe as the effect
/// says.
TEST(ErrorSymbols, SquarenessTurnsTheAxisRightHandedByItsSign) {
  constexpr double kSlope = 1e-5, kTravel = 0.1;
  const std::vector<std::string> names = {"x", "y", "z"};
  for (const double sense : {1.0, -1.0})
    for (std::size_t along = 0; along < 3; ++along)
      for (std::size_t of = 0; of < 3; ++of) {
        if (along == of) continue;
        const auto about = static_cast<Eigen::Index>(3 - along - of);
        std::vector<test::ChainJoint> joints;
        std::string link = "workpiece";
        for (std::size_t j = 0; j < 3; ++j) {
          Eigen::Vector3d axis = Eigen::Vector3d::Unit(static_cast<Eigen::Index>(j));
          if (j == of) axis *= sense;
          joints.push_back(
              {names[j], link, j == 2 ? "probe_tip" : names[j] + "_slide", test::kAlong,
               std::to_string(axis.x()) + " " + std::to_string(axis.y()) + " " + std::to_string(axis.z())});
          link = joints.back().child;
        }
        const EffectSpec effect = EffectSpec("squareness").set("axis", names[along]).set("of", names[of]);
        const ErrorSymbols symbols(test::chainOf("three", joints));
        const Eigen::Vector3d u = sense * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(of));
        const double angle = symbols.squarenessSign(effect) * kSlope;
        const Eigen::Vector3d displaced = kTravel * angle * Eigen::Vector3d::Unit(about).cross(u);
        EXPECT_NEAR(displaced[static_cast<Eigen::Index>(along)], kSlope * kTravel, 1e-15)
            << names[of] << " to " << names[along] << ", sense " << sense;
        EXPECT_EQ(symbols.of(effect), std::string(1, "ABC"[about]) + "0" + std::string(1, "XYZ"[of]));
      }
  EXPECT_EQ(ErrorSymbols(Machine::load("three_axis")).squarenessSign(EffectSpec("scale").set("axis", "x")),
            0);
}

}  // namespace
}  // namespace mm
