#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

double movedBy(const std::string& target, const TableFolder& folder, const std::string& joint, double x,
               double y, double z, int direction = 1) {
  return addedMicrometres(*interpret(target, folder.path()),
                          atMillimetres({{"x", x}, {"y", y}, {"z", z}}, direction), joint);
}

// module/planner.h: sx = x - y xy - z (xz - xy yz), sy = y - z yz
TEST(MarlinInterpreter, SkewFactorsAreTakenOff) {
  TableFolder folder;
  folder.file("compensation.gcode", "; skew\nM852 I0.01 J0.02 K0.03\nM500\n");
  EXPECT_NEAR(movedBy("marlin", folder, "x", 10, 20, 30), -791.0, kNanometre);
  EXPECT_NEAR(movedBy("marlin", folder, "y", 10, 20, 30), -900.0, kNanometre);
}

// feature/backlash.cpp, get_applied_steps: nothing forwards, the whole of it backwards; the fraction is a
// byte
TEST(MarlinInterpreter, BacklashIsTakenUpBackwardsByItsFraction) {
  TableFolder off, full, half;
  off.file("compensation.gcode", "M425 X0.1\n");
  EXPECT_NEAR(movedBy("marlin", off, "x", 1, 1, 1, -1), 0.0, kNanometre);
  full.file("compensation.gcode", "M425 F1 X0.1 Z0.02 S3\n");
  EXPECT_NEAR(movedBy("marlin", full, "x", 1, 1, 1, 1), 0.0, kNanometre);
  EXPECT_NEAR(movedBy("marlin", full, "x", 1, 1, 1, -1), -100.0, kNanometre);
  EXPECT_NEAR(movedBy("marlin", full, "z", 1, 1, 1, 0), -10.0, kNanometre);
  half.file("compensation.gcode", "M425 X0.1\nM425 F0.5\n");
  EXPECT_NEAR(movedBy("marlin", half, "x", 1, 1, 1, -1), -100.0 * 128.0 / 255.0, kNanometre);
}

TEST(MarlinInterpreter, WhatMarlinDoesNotTakeIsRefused) {
  TableFolder inches;
  EXPECT_THAT(refusalOf("marlin", {{"compensation.gcode", "M852 I1.5\n"}}),
              AllOf(HasSubstr("compensation.gcode:1"), HasSubstr("M852 I"), HasSubstr("-1 to 1")));
  EXPECT_THAT(refusalOf("marlin", {{"compensation.gcode", "G21\nM852 I0.0.1\n"}}),
              AllOf(HasSubstr(":2"), HasSubstr("'0.0.1' is not a number")));
  EXPECT_THAT(refusalOf("marlin", {{"compensation.gcode", "M425 Q1\n"}}),
              HasSubstr("M425: 'Q1' is none of the letters"));
  EXPECT_THAT(refusalOf("marlin", {{"compensation.gcode", "G20\nM852 I0.01\n"}}),
              AllOf(HasSubstr("compensation.gcode:1"), HasSubstr("inches are not read")));
}

// The example of M556: S100 X0.7 Y-0.2 Z0.6 is reported as XY 0.00700, YZ -0.00200, ZX 0.00600
TEST(ReprapfirmwareInterpreter, TangentsOfTheDocumentedExampleAreAdded) {
  TableFolder folder;
  folder.file("config-override.g", "M556 S100 X0.7 Y-0.2 Z0.6\n");
  EXPECT_NEAR(movedBy("reprapfirmware", folder, "x", 100, 200, 50), 1400.0 + 300.0, kNanometre);
  EXPECT_NEAR(movedBy("reprapfirmware", folder, "y", 100, 200, 50), -100.0, kNanometre);
  EXPECT_THAT(refusalOf("reprapfirmware", {{"config.g", "M556 S100 X0.7 Y-0.2 Z0.6 P1 ; by y\n"}}),
              AllOf(HasSubstr("config.g:1"), HasSubstr("M556: 'P1' is none of")));
}

TEST(ReprapfirmwareInterpreter, TheOverrideComesLast) {
  TableFolder folder;
  folder.file("config.g", "M556 S1 X0.5\nM425 X0.3\n")
      .file("config-override.g", "M556 S1 X0\nM425 X0.01 S5\n");
  EXPECT_NEAR(movedBy("reprapfirmware", folder, "x", 10, 10, 0, 1), 0.0, kNanometre);
  EXPECT_NEAR(movedBy("reprapfirmware", folder, "x", 10, 10, 0, -1), -10.0, kNanometre);
}

TEST(ReprapfirmwareInterpreter, WhatHasNoHeightIsRefused) {
  EXPECT_THAT(refusalOf("reprapfirmware", {{"config.g", "G28\nM556 X0.7\n"}}),
              AllOf(HasSubstr("config.g:2"), HasSubstr("S")));
  EXPECT_THAT(refusalOf("reprapfirmware", {{"config.g", "M556 S0 X0.7\n"}}), HasSubstr("M556"));
  EXPECT_THAT(refusalOf("reprapfirmware", {{"config.g", "M425 X-0.1\n"}}),
              AllOf(HasSubstr("M425 X"), HasSubstr("below 0")));
}

// motion_control.c: dir_negative begins as the direction of the pull-off, against the search for the switch
TEST(GrblhalInterpreter, BacklashIsCountedFromThePullOff) {
  TableFolder toPlus, toMinus;
  toPlus.file("settings.txt", "$23=0 (homing direction invert mask)\n$160=0.050\n$161=0.00005\n");
  EXPECT_NEAR(movedBy("grblhal", toPlus, "x", 1, 1, 1, 1), 50.0, kNanometre);
  EXPECT_NEAR(movedBy("grblhal", toPlus, "x", 1, 1, 1, -1), 0.0, kNanometre);
  EXPECT_NEAR(movedBy("grblhal", toPlus, "y", 1, 1, 1, 1), 0.0, kNanometre);  // 0.0001 is the least
  toMinus.file("settings.txt", "[MSG:ok]\n$23=1\n$160=0.050\nok\n");
  EXPECT_NEAR(movedBy("grblhal", toMinus, "x", 1, 1, 1, 1), 0.0, kNanometre);
  EXPECT_NEAR(movedBy("grblhal", toMinus, "x", 1, 1, 1, -1), -50.0, kNanometre);
}

TEST(GrblhalInterpreter, WhatIsNoBacklashIsRefused) {
  EXPECT_THAT(refusalOf("grblhal", {{"settings.txt", "$0=10\n$162=-0.1\n"}}),
              AllOf(HasSubstr("settings.txt:2"), HasSubstr("$162"), HasSubstr("-0.1")));
  EXPECT_THAT(refusalOf("grblhal", {{"settings.txt", "$160=five\n"}}), HasSubstr("'five' is not a number"));
}

}  // namespace
}  // namespace mm
