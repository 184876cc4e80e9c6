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
  return "$AN_CEC[0,0]=0\n$AN_CEC[0,1]=0.010\n$AN_CEC[0,2]=0.012\n$AN_CEC_INPUT_AXIS[0]=(Y1)\n"
         "N10 $AN_CEC_OUTPUT_AXIS[0] = "
         "(X1)\n$AN_CEC_STEP[0]=100\n$AN_CEC_MIN[0]=-400.0\n$AN_CEC_MAX[0]=-200.0\n" +
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

TEST(SiemensInterpreter, DirectionAndEnableDecideWhatCounts) {
  TableFolder up, off, axisOff;
  up.file("cec.mpf", cecTable("$AN_CEC_DIRECTION[0]=1\n"));
  EXPECT_NEAR(moved(up, "x", 0, -300, 1), -10.0, kNanometre);
  EXPECT_NEAR(moved(up, "x", 0, -300, -1), 0.0, kNanometre);
  EXPECT_NEAR(moved(up, "x", 0, -300, 0), -5.0, kNanometre);
  off.file("cec.mpf", cecTable("$SN_CEC_TABLE_ENABLE[0]=0\n"));
  EXPECT_NEAR(moved(off, "x", 0, -300), 0.0, kNanometre);
  axisOff.file("cec.mpf", cecTable("$MA_CEC_ENABLE[X1]=0\n"));
  EXPECT_NEAR(moved(axisOff, "x", 0, -300), 0.0, kNanometre);
}

TEST(SiemensInterpreter, BacklashIsTakenUpBackwards) {
  TableFolder folder;
  folder.file("axes.ini", "N32450 $MA_BACKLASH[0,X1]=0.02\n");
  EXPECT_NEAR(moved(folder, "x", 0, 0, 1), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, "x", 0, 0, -1), -20.0, kNanometre);
}

TEST(SiemensInterpreter, VariablesOfWhichNoRuleIsKnownAreRefused) {
  const std::pair<const char*, const char*> lines[] = {
      {"$AN_CEC_MULT_BY_TABLE[0]=1", "1 is not read, only 0"},
      {"$AN_CEC_IS_MODULO[0]=1", "1 is not read, only 0"},
      {"$SN_CEC_TABLE_WEIGHT[0]=0.5", "0.5 is not read, only 1"},
      {"$AN_CEC_MAX[0]=-250", "whole steps"},
      {"$MA_BACKLASH[0,AX1]=0.02", "'AX1' is not an axis"},
      {"$MA_BACKLASH[X1]=0.02", "has 2 indices in brackets, not 1"},
      {"$AN_CEC[62,0]=0.01", "62"},
      {"$AN_CEC[0,003]=0.01", "$AN_CEC[0,3]: lies beyond $AN_CEC_MAX[0]"}};
  for (const auto& [line, why] : lines) {
    EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable(line)}}),
                AllOf(HasSubstr("cec.mpf:9: "), HasSubstr(why)))
        << line;
  }
}

TEST(SiemensInterpreter, WhatTheControlWouldNotLoadIsRefused) {
  TableFolder points, axis;
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable("$MN_MM_CEC_MAX_POINTS[0]=2\n")}}),
              AllOf(HasSubstr("cec.mpf:9"), HasSubstr("asks for 3 points")));
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", "$AN_CEC[3,0]=0\n$AN_CEC_INPUT_AXIS[3]=(X1)\n"}}),
              HasSubstr("$AN_CEC_OUTPUT_AXIS[3] is missing"));
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable("$AN_CEC_STP[0]=1\n")}}),
              AllOf(HasSubstr("cec.mpf:9"), HasSubstr("$AN_CEC_STEP")));
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable("$AN_CEC_STEP[0]=0\n")}}),
              AllOf(HasSubstr("_STEP"), HasSubstr("not above 0")));
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable("$AN_CEC_INPUT_AXIS[0]=(Q1)\n")}}),
              HasSubstr("'Q1' is not an axis"));
  EXPECT_THAT(refusalOf("siemens", {{"cec.mpf", cecTable("$AN_CEC_DIRECTION[0]=2\n")}}),
              AllOf(HasSubstr("$AN_CEC_DIRECTION"), HasSubstr("2 is not within -1 to 1")));
}

}  // namespace
}  // namespace mm
