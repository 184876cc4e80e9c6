#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

double moved(const TableFolder& folder, const std::string& joint, double x, double y, double z) {
  return addedMicrometres(*interpret("klipper", folder.path()), atMillimetres({{"x", x}, {"y", y}, {"z", z}}),
                          joint);
}

std::string mesh(const std::string& points, int columns, int rows, const std::string& algorithm = "direct") {
  return "[bed_mesh]\n[bed_mesh first]\nversion: 1\npoints:\n" + points +
         "x_count: " + std::to_string(columns) + "\ny_count: " + std::to_string(rows) +
         "\nmesh_x_pps: 0\nmesh_y_pps: 0\nalgo: " + algorithm +
         "\ntension: 0.2\nmin_x: 0\nmax_x: 100\nmin_y: 0\nmax_y: 100\n";
}

const char* const kLoad = "BED_MESH_PROFILE LOAD=first\n";

TEST(KlipperInterpreter, SkewOfAProfileIsTakenOffAsMarlinDoes) {
  TableFolder folder;
  folder
      .file("printer.cfg",
            "[skew_correction]\n[skew_correction plate]\nxy_skew = 0.01\nxz_skew = 0.02\nyz_skew = 0.03\n")
      .file("start.gcode", "G28\nSKEW_PROFILE LOAD=plate\n");
  // x = 10 - 20 0.01 - 30 (0.02 - 0.01 0.03), y = 20 - 30 0.03
  EXPECT_NEAR(moved(folder, "x", 10, 20, 30), -791.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", 10, 20, 30), -900.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 10, 20, 30), 0.0, kNanometre);
}

TEST(KlipperInterpreter, AProfileThatIsNotLoadedDoesNothing) {
  TableFolder folder;
  folder.file("printer.cfg",
              "[skew_correction]\n[skew_correction p]\nxy_skew: 0.01\nxz_skew: 0\nyz_skew: 0\n");
  EXPECT_NEAR(moved(folder, "x", 10, 20, 30), 0.0, kNanometre);
  // and then no other axis is needed
  EXPECT_EQ(interpret("klipper", folder.path())->motors(atMillimetres({{"x", 10}})).size(), 1u);
}

// docs/Skew_Correction.md measures 140.4, 142.8 and 99.8 mm; by the law of cosines in the parallelogram
// (AC² - BD²) / (4 AD AB sin of its angle) is the tangent.
TEST(KlipperInterpreter, LengthsOfAParallelogramAreItsSkew) {
  TableFolder folder;
  folder.file("printer.cfg", "[skew_correction]\n").file("start.gcode", "SET_SKEW XY=140.4,142.8,99.8\n");
  const double ac = 140.4, bd = 142.8, ad = 99.8;
  const double ab = std::sqrt((ac * ac + bd * bd) / 2.0 - ad * ad);
  const double cosine = (ac * ac - bd * bd) / (4.0 * ad * ab),
               tangent = cosine / std::sqrt(1.0 - cosine * cosine);
  EXPECT_NEAR(moved(folder, "x", 0, 100, 0), -100e3 * tangent, kNanometre);
}

TEST(KlipperInterpreter, AMeshIsStraightBetweenItsPointsAndHoldsItsBorder) {
  TableFolder folder;
  folder.file("printer.cfg", mesh("  0, 0.01, 0.1\n  0.02, 0.03, 0.12\n", 3, 2)).file("start.gcode", kLoad);
  EXPECT_NEAR(moved(folder, "z", 25, 0, 0), 5.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 75, 50, 400), 65.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 140, 200, 0), 120.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", -40, -1, 0), 0.0, kNanometre);
}

TEST(KlipperInterpreter, TheMeshIsReadWhereTheSkewLeads) {
  TableFolder folder;
  folder
      .file("printer.cfg", "[skew_correction]\n[skew_correction s]\nxy_skew: 0.1\nxz_skew: 0\nyz_skew: 0\n" +
                               mesh("  0, 0.1\n  0, 0.1\n", 2, 2))
      .file("start.gcode", "BED_MESH_PROFILE LOAD=first\nSKEW_PROFILE LOAD=s\n");
  EXPECT_NEAR(moved(folder, "z", 60, 100, 0), 50.0, kNanometre);
}

TEST(KlipperInterpreter, HeatLowersZByTheCoefficient) {
  TableFolder folder;
  folder.file("printer.cfg", "[z_thermal_adjust]\ntemp_coeff: 0.01\nmax_z_adjustment: 0.15\n")
      .file("start.gcode", "SET_Z_THERMAL_ADJUST REF_TEMP=25\n");
  const auto interpreter = interpret("klipper", folder.path());
  CommandedState command = atMillimetres({{"x", 0}, {"y", 0}, {"z", 5}});
  EXPECT_THROW(interpreter->motors(command), InputError);
  command.temperature["z_thermal_adjust"] = 35.0;
  EXPECT_NEAR(addedMicrometres(*interpreter, command, "z"), -100.0, kNanometre);
  command.temperature["z_thermal_adjust"] = 5.0;
  EXPECT_NEAR(addedMicrometres(*interpreter, command, "z"), 150.0, kNanometre);
}

TEST(KlipperInterpreter, ClearTakesNothingFromBesideIt) {
  TableFolder folder;
  folder.file("printer.cfg", "[skew_correction]\n[gcode_macro GO]\ngcode: M117 go\n  G28\n")
      .file("start.gcode", "SET_SKEW CLEAR=1 XY=140,142,100\n");
  EXPECT_NEAR(moved(folder, "x", 60, 100, 0), 0.0, kNanometre);
}

TEST(KlipperInterpreter, WhatKlipperAnswersWithAnErrorIsRefused) {
  TableFolder lengths;
  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", "[skew_correction]\n"},
                                    {"start.gcode", "\nSKEW_PROFILE LOAD=none\n"}}),
              AllOf(HasSubstr("start.gcode:2"), HasSubstr("none")));
  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", mesh("  0, 0.1\n  0\n", 2, 2)}, {"start.gcode", kLoad}}),
              AllOf(HasSubstr("printer.cfg:6"), HasSubstr("x_count is 2")));
  EXPECT_THAT(refusalOf("klipper",
                        {{"printer.cfg", "[skew_correction]\n"}, {"start.gcode", "SET_SKEW XY=140,142\n"}}),
              AllOf(HasSubstr("start.gcode:1"), HasSubstr("three lengths")));
  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", ""}, {"start.gcode", "SET_SKEW CLEAR=1\n"}}),
              HasSubstr("[skew_correction]"));
}

TEST(KlipperInterpreter, WhatNoRuleIsKnownOfIsRefused) {
  const std::string two = "  0, 0.1\n  0, 0.1\n", heat = "[z_thermal_adjust]\ntemp_coeff: 0.01\n";

  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", mesh(two, 2, 2, "bicubic")}, {"start.gcode", kLoad}}),
              AllOf(HasSubstr("printer.cfg:11"), HasSubstr("'bicubic' is not read, only")));
  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", "[bed_mesh]\nfade_end: 10\n" + mesh(two, 2, 2)},
                                    {"start.gcode", kLoad}}),
              AllOf(HasSubstr("printer.cfg:2"), HasSubstr("fade_end")));
  EXPECT_THAT(
      refusalOf("klipper", {{"printer.cfg", mesh(two, 2, 2) + "[gcode_macro START]\ngcode:\n  " + kLoad}}),
      AllOf(HasSubstr("printer.cfg:19"), HasSubstr("start.gcode alone")));
  EXPECT_THAT(
      refusalOf("klipper", {{"printer.cfg", mesh(two, 2, 2) + "[gcode_macro START]\ngcode: " + kLoad}}),
      HasSubstr("start.gcode alone"));
  EXPECT_THAT(refusalOf("klipper", {{"printer.cfg", heat}}),
              AllOf(HasSubstr("printer.cfg:1"), HasSubstr("REF_TEMP")));
  EXPECT_THAT(refusalOf("klipper",
                        {{"printer.cfg", heat}, {"start.gcode", "SET_Z_THERMAL_ADJUST TEMP_COEFF=0.02\n"}}),
              AllOf(HasSubstr("start.gcode:1"), HasSubstr("TEMP_COEFF")));
}

}  // namespace
}  // namespace mm
