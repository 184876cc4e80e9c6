#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// The example of the leadscrew error compensation in K3 (6FC5397-1BP40-3BA1, page 242): 801 points from -200
// mm.
const char* const kEncoderExample =
    "%_N_AX_EEC_INI\nCHANDATA(1)\n"
    "$AA_ENC_COMP[0,0,X1]=0.003 ; 1st compensation "
    "value\n$AA_ENC_COMP[0,1,X1]=0.01\n$AA_ENC_COMP[0,2,X1]=0.012\n"
    "$AA_ENC_COMP_STEP[0,X1]=1.0\n$AA_ENC_COMP_MIN[0,X1]=-200.0\n$AA_ENC_COMP_MAX[0,X1]=600.0\n"
    "$AA_ENC_COMP_IS_MODULO[0,X1]=0\nM17\n";

std::string cecTable(const std::string& more) {
  return "$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.010\n$AN_CEC[0,2]=0.012\n$AN_CEC_INPUT_AXIS[0]=(AX2)\n"
         "N10 $AN_CEC_OUTPUT_AXIS[0] = "
         "(AX1)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=-400.0\n$AN_CEC_MAX[0]=-200.0\n" +
         more;
}

double moved(const TableFolder& folder, const std::string& joint, double x, double y, int direction = 1) {
  return addedMicrometres(*interpret("siemens", folder.path()),
                          atMillimetres({{"x", x}, {"y", y}}, direction), joint);
}

// 808D Function Manual 01/2017, page 106: "positive compensation value": the axis moves in the negative
// direction
TEST(SiemensInterpreter, APositiveValueOfTheEncoderTableMovesTheAxisBack) {
  TableFolder folder;
  folder.file("eec.mpf", kEncoderExample);
  EXPECT_NEAR(moved(folder, "x", -200, 0), -3.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", -199.5, 0), -6.5, kNanometre);
  EXPECT_NEAR(moved(folder, "x", -198, 0), -12.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", -197, 0), 0.0, kNanometre);  // points without a value are 0
  EXPECT_NEAR(moved(folder, "x", -300, 0), -3.0, kNanometre);
}

TEST(SiemensInterpreter, TheBaseAxisMovesTheCompensationAxis) {
  TableFolder folder;
  folder.file("cec.mpf", cecTable(""));
  EXPECT_NEAR(moved(folder, "x", 7, -350), -5.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 7, -250), -11.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 7, 100), -12.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 7, -900), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", 7, -250), 0.0, kNanometre);
}

TEST(SiemensInterpreter, DirectionWeightAndEnableDecideWhatCounts) {
  TableFolder up, weighed, off, axisOff;
  up.file("cec.mpf", cecTable("$AN_CEC_DIRECTION[0]=1\n"));
  EXPECT_NEAR(moved(up, "x", 0, -300, 1), -10.0, kNanometre);
  EXPECT_NEAR(moved(up, "x", 0, -300, -1), 0.0, kNanometre);
  EXPECT_NEAR(moved(up, "x", 0, -300, 0), -5.0, kNanometre);
  weighed.file("cec.mpf", cecTable("$SN_CEC_TABLE_WEIGHT[0]=0.5\n"));
  EXPECT_NEAR(moved(weighed, "x", 0, -300), -5.0, kNanometre);
  off.file("cec.mpf", cecTable("$SN_CEC_TABLE_ENABLE[0]=0\n"));
  EXPECT_NEAR(moved(off, "x", 0, -300), 0.0, kNanometre);
  axisOff.file("cec.mpf", cecTable("$MA_CEC_ENABLE[X1]=0\n"));
  EXPECT_NEAR(moved(axisOff, "x", 0, -300), 0.0, kNanometre);
}

TEST(SiemensInterpreter, ATableMultipliedByItselfAddsItsSquare) {
  TableFolder folder;
  folder.file("cec.mpf", cecTable("$AN_CEC[0,1]=0.5\n$AN_CEC_MULT_BY_TABLE[0]=1\n"));
  EXPECT_NEAR(moved(folder, "x", 0, -300), -500.0 - 250.0, kNanometre);
}

TEST(SiemensInterpreter, AModuloTableIsRepeated) {
  TableFolder folder;
  folder.file("cec.mpf", cecTable("$AN_CEC_IS_MODULO[0]=1\n"));
  EXPECT_NEAR(moved(folder, "x", 0, -350 + 200), -5.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 0, -350 - 600), -5.0, kNanometre);
}

TEST(SiemensInterpreter, TheTableEndsAtItsMaximum) {
  TableFolder folder;
  folder.file("cec.mpf", cecTable("$AN_CEC_MAX[0]=-250\n"));
  EXPECT_NEAR(moved(folder, "x", 0, -250), -11.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 0, 0), -11.0, kNanometre);
}

TEST(SiemensInterpreter, BacklashIsTakenUpAgainstTheSearchForTheReference) {
  TableFolder plus, minus;
  plus.file("axes.ini", "N32450 $MA_BACKLASH[0,AX1]=0.02\n");
  EXPECT_NEAR(moved(plus, "x", 0, 0, 1), 0.0, kNanometre);
  EXPECT_NEAR(moved(plus, "x", 0, 0, -1), -20.0, kNanometre);
  minus.file("axes.ini", "$MA_BACKLASH[0,AX1]=0.02\n$MA_REFP_CAM_DIR_IS_MINUS[AX1]=1\n");
  EXPECT_NEAR(moved(minus, "x", 0, 0, 1), 20.0, kNanometre);
  EXPECT_NEAR(moved(minus, "x", 0, 0, -1), 0.0, kNanometre);
}

TEST(SiemensInterpreter, WhatTheControlWouldNotLoadIsRefused) {
  TableFolder points, output, word, step, axis, direction;
  points.file("cec.mpf", std::string("$MA_MM_ENC_COMP_MAX_POINTS[0,X1]=800\n") + kEncoderExample);
  EXPECT_THAT(refusal("siemens", points),
              AllOf(HasSubstr("$AA_ENC_COMP"), HasSubstr("801 points of at most 800")));
  output.file("cec.mpf", "$AN_CEC[3,0]=0\n$AN_CEC_INPUT_AXIS[3]=(X1)\n");
  EXPECT_THAT(refusal("siemens", output),
              AllOf(HasSubstr("cec.mpf:1"), HasSubstr("table 3"), HasSubstr("_OUTPUT_AXIS")));
  word.file("cec.mpf", cecTable("$AN_CEC_STP[0]=1\n"));
  EXPECT_THAT(refusal("siemens", word), AllOf(HasSubstr("cec.mpf:9"), HasSubstr("$AN_CEC_STEP")));
  step.file("cec.mpf", cecTable("$AN_CEC_STEP[0]=0\n"));
  EXPECT_THAT(refusal("siemens", step), AllOf(HasSubstr("_STEP"), HasSubstr("not above 0")));
  axis.file("cec.mpf", cecTable("$AN_CEC_INPUT_AXIS[0]=(Q1)\n"));
  EXPECT_THAT(refusal("siemens", axis), HasSubstr("'Q1' is no axis"));
  direction.file("cec.mpf", cecTable("$AN_CEC_DIRECTION[0]=2\n"));
  EXPECT_THAT(refusal("siemens", direction),
              AllOf(HasSubstr("$AN_CEC_DIRECTION"), HasSubstr("2 is not within -1 to 1")));
}

}  // namespace
}  // namespace mm
