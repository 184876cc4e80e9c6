// What is told of a compensation: kinds of errors, chain, directions of travel, squareness with its sign,
// volume.
#include "export/compensation_statement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "compensation_support.h"
#include "machine_chains.h"

namespace mm {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

EffectSpec on(const char* type, const char* axis) { return EffectSpec(type).set("axis", axis); }

std::string factOf(const Calibration& c, const std::vector<EffectSpec>& compensated,
                   const std::string& name) {
  for (const CompensationFact& fact : compensationFacts(c, compensated))
    if (fact.name == name) return fact.text;
  return "no fact " + name;
}

std::string factOf(const Calibration& c, const std::string& name) { return factOf(c, c.effects, name); }

TEST(CompensationStatement, NamesTheErrorsByKindAndSymbol) {
  const Calibration c = test::calibrationOf(
      Machine::load("five_axis"),
      {on("scale", "x"), on("backlash", "x"), on("lead_screw_periodic", "z").set("period_mm", 2),
       on("straightness", "x").set("direction", "y").set("degree", 2),
       on("angular_motion", "z").set("about", "x"), on("squareness", "x").set("of", "z"), on("scale", "b"),
       EffectSpec("rotary_wobble").set("joint", "a").set("harmonic", 1),
       EffectSpec("rotary_axis_tilt").set("joint", "b").set("about", "y"),
       on("thermal_expansion", "y").set("sensor", "bed")});
  EXPECT_EQ(factOf(c, "Errors compensated"),
            "positioning errors of linear axes (EXX, EZZ); straightness errors of linear axes (EYX); angular "
            "errors of "
            "linear axes (EAZ); squareness errors between linear axes (B0Z); positioning errors of rotary "
            "axes (ECC); "
            "error motions of rotary axes (EBA, ECA); errors of position and orientation of rotary axes "
            "(B0C); errors "
            "that depend on more than the position of one axis (thermal expansion of y with bed)");
  EXPECT_EQ(factOf(c, {c.effects[3]}, "Errors compensated"), "straightness errors of linear axes (EYX)");
  EXPECT_EQ(factOf(c, {}, "Errors compensated"), "none");
  EXPECT_EQ(factOf(c, "Kinematic chain"), "w-Y-X-b-Z-C-A-t (w workpiece, b bed, t probe); joint b is C");
}

TEST(CompensationStatement, IsBidirectionalWhereAnErrorDependsOnTheDirectionOfTravel) {
  const Calibration c =
      test::calibrationOf(Machine::load("three_axis"), {on("scale", "x"), on("backlash", "y")});
  EXPECT_EQ(factOf(c, "Directions of travel"),
            "bidirectional: Y; unidirectional, one value for both directions of travel: X, Z");
  EXPECT_EQ(factOf(c, {c.effects[0]}, "Directions of travel"),
            "unidirectional, one value for both directions of travel: X, Y, Z");
  const Calibration all = test::calibrationOf(
      Machine::load("three_axis"), {on("backlash", "x"), on("backlash", "y"), on("lost_motion", "z")});
  EXPECT_EQ(factOf(all, "Directions of travel"), "bidirectional: X, Y, Z");
}

TEST(CompensationStatement, TellsSquarenessByItsSign) {
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {on("squareness", "x").set("of", "y"),
                                                                    on("squareness", "x").set("of", "z")});
  c.values[0].value = 12e-6;  // y leans to +x: turned about -z
  c.values[1].value = 5e-6;   // z leans to +x: turned about +y
  c.values[0].std = c.values[1].std = 0.2e-6;
  EXPECT_THAT(factOf(c, "Squareness"),
              StartsWith("C0Y = -12.0 ± 0.4 um/m (k = 2); B0Z = 5.0 ± 0.4 um/m (k = 2). "));
  EXPECT_THAT(factOf(c, {c.effects[1]}, "Squareness"), StartsWith("B0Z = 5.0"));
  EXPECT_EQ(factOf(c, {}, "Squareness"), "none is compensated");
}

TEST(CompensationStatement, TellsTheLimitsOfTheVolume) {
  Calibration c = test::calibrationOf(test::headHead(), {on("scale", "j1")});
  c.domain.sensorLower[1] = c.domain.sensorUpper[1] = test::kUnknown;
  EXPECT_EQ(factOf(c, "Compensated volume"),
            "X -20 to 20 mm, Y -20 to 20 mm, Z -20 to 20 mm, C -57.3 to 57.3 deg, A -57.3 to 57.3 deg, "
            "temperature bed 18 to 26 degC");
  EXPECT_THAT(factOf(c, "Kinematic chain"), HasSubstr("; joint j1 is X, j2 is Y, j3 is Z, j4 is C, j5 is A"));
}

}  // namespace
}  // namespace mm
