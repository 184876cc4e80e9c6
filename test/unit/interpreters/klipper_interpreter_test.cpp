#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

double moved(const TableFolder& folder, const std::string& joint, double x, double y, double z) {
  return addedMicrometres(*interpret("klipper", folder.path()), atMillimetres({{"x", x}, {"y", y}, {"z", z}}),
                          joint);
}

std::string mesh(const std::string& algorithm, int between, const std::string& points, int columns,
                 int rows) {
  return "[bed_mesh]\n[bed_mesh first]\nversion: 1\npoints:\n" + points +
         "x_count: " + std::to_string(columns) + "\ny_count: " + std::to_string(rows) +
         "\nmesh_x_pps: " + std::to_string(between) + "\nmesh_y_pps: " + std::to_string(between) +
         "\nalgo: " + algorithm + "\ntension: 0.2\nmin_x: 0\nmax_x: 100\nmin_y: 0\nmax_y: 100\n";
}

const char* const kParabola = "  0.0, 0.025, 0.1\n  0.0, 0.025, 0.1\n  0.0, 0.025, 0.1\n";  // x² 1e-5 / mm

TEST(KlipperInterpreter, SkewOfAProfileIsTakenOffAsMarlinDoes) {
  TableFolder folder;
  folder
      .file("printer.cfg",
            "[skew_correction]\n\n#*# <--- SAVE_CONFIG --->\n#*# DO NOT EDIT THIS BLOCK OR BELOW.\n#*#\n"
            "#*# [skew_correction plate]\n#*# xy_skew = 0.01\n#*# xz_skew = 0.02\n#*# yz_skew = 0.03\n")
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
  folder.file("printer.cfg",
              "[skew_correction]\n[delayed_gcode begin]\ninitial_duration: 1\ngcode:\n"
              "  SET_SKEW XY=140.4,142.8,99.8\n");
  const double ac = 140.4, bd = 142.8, ad = 99.8;
  const double ab = std::sqrt((ac * ac + bd * bd) / 2.0 - ad * ad);
  const double cosine = (ac * ac - bd * bd) / (4.0 * ad * ab),
               tangent = cosine / std::sqrt(1.0 - cosine * cosine);
  EXPECT_NEAR(moved(folder, "x", 0, 100, 0), -100e3 * tangent, kNanometre);
}

TEST(KlipperInterpreter, LagrangeFollowsAParabolaAndIsStraightBetweenItsPoints) {
  TableFolder folder;
  folder.file("printer.cfg", mesh("lagrange", 1, kParabola, 3, 3))
      .file("start.gcode", "BED_MESH_PROFILE LOAD=first\n");
  EXPECT_NEAR(moved(folder, "z", 25, 60, 0), 6.25, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 12.5, 60, 0), 3.125, kNanometre);
  EXPECT_NEAR(moved(folder, "z", -40, 0, 0), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 140, 0, 0), 100.0, kNanometre);
}

TEST(KlipperInterpreter, BicubicIsACardinalSpline) {
  TableFolder folder;
  folder.file("printer.cfg", mesh("bicubic", 1, "  0, 0.1, 0.2, 0\n  0, 0.1, 0.2, 0\n", 4, 2))
      .file("start.gcode", "BED_MESH_PROFILE LOAD=first\n");
  // halfway between 0.1 and 0.2 with slopes 0.2 (0.2 - 0) and 0.2 (0 - 0.1): 0.15 + (0.04 + 0.02) / 8
  EXPECT_NEAR(moved(folder, "z", 50, 50, 0), 157.5, kNanometre);
}

TEST(KlipperInterpreter, AMeshFadesToItsTarget) {
  TableFolder folder;
  const std::string fading = "[bed_mesh]\nfade_start: 1\nfade_end: 11\nfade_target: 0.02\n";
  folder.file("printer.cfg", fading + mesh("direct", 0, "  0, 0.1\n  0, 0.1\n", 2, 2))
      .file("start.gcode", "BED_MESH_PROFILE LOAD=first\n");
  EXPECT_NEAR(moved(folder, "z", 100, 0, 0), 100.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 100, 0, 6), 20.0 + 0.5 * 80.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 100, 0, 11), 20.0, kNanometre);
}

TEST(KlipperInterpreter, TheMeshIsReadWhereTheSkewLeads) {
  TableFolder folder;
  folder
      .file("printer.cfg", "[skew_correction]\n[skew_correction s]\nxy_skew: 0.1\nxz_skew: 0\nyz_skew: 0\n" +
                               mesh("direct", 0, "  0, 0.1\n  0, 0.1\n", 2, 2))
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

TEST(KlipperInterpreter, TwistCorrectsTheProbeAndNotTheMotors) {
  TableFolder folder;
  folder.file("printer.cfg",
              "[axis_twist_compensation]\ncalibrate_start_x: 0\ncalibrate_end_x: 100\nz_compensations: -0.1, "
              "0, 0.1\n");
  EXPECT_NEAR(moved(folder, "z", 100, 0, 0), 0.0, kNanometre);
}

TEST(KlipperInterpreter, WhatKlipperAnswersWithAnErrorIsRefused) {
  TableFolder unknown, ragged, wide, algorithm, lengths, section;
  unknown.file("printer.cfg", "[skew_correction]\n").file("start.gcode", "\nSKEW_PROFILE LOAD=none\n");
  EXPECT_THAT(refusal("klipper", unknown), AllOf(HasSubstr("start.gcode:2"), HasSubstr("none")));
  const std::string load = "BED_MESH_PROFILE LOAD=first\n";
  ragged.file("printer.cfg", mesh("direct", 0, "  0, 0.1\n  0\n", 2, 2)).file("start.gcode", load);
  EXPECT_THAT(refusal("klipper", ragged), AllOf(HasSubstr("printer.cfg:4"), HasSubstr("x_count is 2")));
  wide.file("printer.cfg",
            "[bed_mesh]\nfade_end: 1.05\nfade_target: 0\n" + mesh("direct", 0, "  0, 0.1\n  0, 0.1\n", 2, 2))
      .file("start.gcode", load);
  EXPECT_THAT(refusal("klipper", wide), AllOf(HasSubstr("printer.cfg:2"), HasSubstr("fade_end")));
  algorithm.file("printer.cfg", mesh("spline", 0, "  0, 0.1\n  0, 0.1\n", 2, 2)).file("start.gcode", load);
  EXPECT_THAT(refusal("klipper", algorithm), AllOf(HasSubstr("algo"), HasSubstr("spline")));
  lengths.file("printer.cfg", "[skew_correction]\n").file("start.gcode", "SET_SKEW XY=140,142\n");
  EXPECT_THAT(refusal("klipper", lengths), AllOf(HasSubstr("start.gcode:1"), HasSubstr("three lengths")));
  section.file("printer.cfg", "").file("start.gcode", "SET_SKEW CLEAR=1\n");
  EXPECT_THAT(refusal("klipper", section), HasSubstr("[skew_correction]"));
}

}  // namespace
}  // namespace mm
