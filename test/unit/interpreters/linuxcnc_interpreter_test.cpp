#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const char* const kHead = "[TRAJ]\nCOORDINATES = X Y A\nLINEAR_UNITS = mm\n";

TableFolder& withCompFile(TableFolder& folder, const std::string& table, const std::string& more = "") {
  return folder
      .file("machine.ini", std::string(kHead) + "[JOINT_0]\nTYPE = LINEAR\nCOMP_FILE = joint0.comp\n" + more)
      .file("joint0.comp", table);
}

// The triplets of the remark in usrmotLoadComp (src/emc/motion/usrmotintf.cc): nominal, forward, reverse.
const char* const kDocumented =
    "0.000000 0.000000 -0.001279\n0.100000 0.098742 0.051632\n0.200000 0.171529 0.194216\n";

double added(const Interpreter& interpreter, double x, int direction) {
  return addedMicrometres(interpreter, atMillimetres({{"x", x}}, direction), "x");
}

TEST(LinuxcncInterpreter, ATripletAddsNominalLessForwardOrReverse) {
  TableFolder folder;
  const auto interpreter = interpret("linuxcnc", withCompFile(folder, kDocumented).path());
  EXPECT_NEAR(added(*interpreter, 0.0, 1), 0.0, kNanometre);
  EXPECT_NEAR(added(*interpreter, 0.0, -1), 1.279, kNanometre);
  EXPECT_NEAR(added(*interpreter, 0.1, 1), 1.258, kNanometre);
  EXPECT_NEAR(added(*interpreter, 0.1, -1), 48.368, kNanometre);
}

TEST(LinuxcncInterpreter, BetweenTripletsTheLineBeyondThemTheEnd) {
  TableFolder folder;
  const auto interpreter = interpret("linuxcnc", withCompFile(folder, kDocumented).path());
  EXPECT_NEAR(added(*interpreter, 0.15, 1), (1.258 + 28.471) / 2.0, kNanometre);
  EXPECT_NEAR(added(*interpreter, -50.0, -1), 1.279, kNanometre);
  EXPECT_NEAR(added(*interpreter, 50.0, 1), 28.471, kNanometre);
  EXPECT_NEAR(added(*interpreter, 50.0, 0), (28.471 + 5.784) / 2.0, kNanometre);
}

TEST(LinuxcncInterpreter, AnotherTypeTakesTheValuesAsTheyAre) {
  TableFolder folder;
  withCompFile(folder, "-10 0.001 0.002\n10 0.003 0.006\n", "COMP_FILE_TYPE = 1\n");
  const auto interpreter = interpret("linuxcnc", folder.path());
  EXPECT_NEAR(added(*interpreter, 0.0, 1), 2.0, kNanometre);
  EXPECT_NEAR(added(*interpreter, 0.0, -1), 4.0, kNanometre);
}

TEST(LinuxcncInterpreter, BacklashIsHalvedAndIgnoredWithATable) {
  TableFolder without, with;
  without.file("machine.ini", std::string(kHead) + "[JOINT_0]\nBACKLASH = 0.01\n");
  EXPECT_NEAR(added(*interpret("linuxcnc", without.path()), 3.0, 1), 5.0, kNanometre);
  EXPECT_NEAR(added(*interpret("linuxcnc", without.path()), 3.0, -1), -5.0, kNanometre);
  EXPECT_NEAR(added(*interpret("linuxcnc", without.path()), 3.0, 0), 0.0, kNanometre);
  withCompFile(with, "0 0 0\n", "BACKLASH = 0.01\n");
  EXPECT_NEAR(added(*interpret("linuxcnc", with.path()), 3.0, 1), 0.0, kNanometre);
}

TEST(LinuxcncInterpreter, AngularJointsAreInDegreesAndOtherUnitsAreRefused) {
  TableFolder folder;
  folder.file("machine.ini",
              "[TRAJ]\nCOORDINATES = XYA\nANGULAR_UNITS = deg\n[JOINT_2]\nTYPE = ANGULAR\nBACKLASH = 0.02\n");
  CommandedState command;
  command.position["a"] = 1.0;
  command.direction["a"] = -1;
  EXPECT_NEAR(interpret("linuxcnc", folder.path())->motors(command).at("a"), 1.0 - 0.01 * kDegree, 1e-12);
  EXPECT_THAT(
      refusalOf("linuxcnc", {{"machine.ini",
                              "[TRAJ]\nCOORDINATES = X\nLINEAR_UNITS = inch\n[JOINT_0]\nBACKLASH = 0.02\n"}}),
      AllOf(HasSubstr("machine.ini:3"), HasSubstr("LINEAR_UNITS: 'inch'"), HasSubstr("only mm")));
}

TEST(LinuxcncInterpreter, WhatLinuxcncReportsIsRefused) {
  TableFolder falling, many, remark;
  EXPECT_THAT(refusal("linuxcnc", withCompFile(falling, "0 0 0\n1 1 1\n1 1 1\n")),
              AllOf(HasSubstr("joint0.comp:3"), HasSubstr("nominal"), HasSubstr("must increase")));
  std::string table;
  for (int i = 0; i < 256; ++i) table += std::to_string(i) + " 0 0\n";
  EXPECT_EQ(refusal("linuxcnc", withCompFile(many, table)), "");
  EXPECT_THAT(refusal("linuxcnc", withCompFile(many, table + "256 0 0\n")),
              AllOf(HasSubstr("joint0.comp:257"), HasSubstr("256")));
  EXPECT_THAT(
      refusalOf("linuxcnc", {{"machine.ini", std::string(kHead) + "[JOINT_1]\nCOMP_FILE = y.comp\n"}}),
      AllOf(HasSubstr("machine.ini:5"), HasSubstr("y.comp")));
  // sscanf finds no number in a remark, and the loop of usrmotLoadComp ends there
  EXPECT_THAT(refusal("linuxcnc", withCompFile(remark, "# x axis\n0 0 0\n")),
              AllOf(HasSubstr("joint0.comp:1"), HasSubstr("stops reading there")));
}

TEST(LinuxcncInterpreter, JointsWithoutAxesAreRefused) {
  EXPECT_THAT(refusalOf("linuxcnc", {{"machine.ini", "[JOINT_0]\nBACKLASH = 1\n"}}),
              HasSubstr("COORDINATES"));
  EXPECT_THAT(refusalOf("linuxcnc", {{"machine.ini", std::string(kHead) + "[JOINT_3]\nBACKLASH = 1\n"}}),
              AllOf(HasSubstr("JOINT_3"), HasSubstr("3 joints")));
}

}  // namespace
}  // namespace mm
