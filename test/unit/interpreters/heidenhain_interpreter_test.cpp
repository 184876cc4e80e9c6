#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// MANUALplus 620, page 716: Y = F(Y) and Z = F(Y) from -90 mm every 5 mm
const char* const kAssignment =
    "BEGIN CONFIG.CMA\nNR  ACTIVE Y\n0   *     AXISY.COM\n1   -     OLD.COM\n[END]\n";
const char* const kTable =
    "BEGIN AXISY.COM MM\nNR AXISPOS BACKLASH Y Z\n0 -90 +0.002 +0.001 +0.01\n1 -85 +0.004 +0.003 "
    "+0.02\n[END]\n";

TableFolder& withTable(TableFolder& folder, const std::string& table) {
  return folder.file("config.cma", kAssignment).file("axisy.com", table);
}

double moved(const TableFolder& folder, const std::string& joint, double y, int direction) {
  return addedMicrometres(*interpret("heidenhain", folder.path()),
                          atMillimetres({{"y", y}, {"z", 0.0}}, direction), joint);
}

// TNC 407, page 151: an error is positive where the axis goes too far
TEST(HeidenhainInterpreter, ErrorsAreTakenOffTheirAxis) {
  TableFolder folder;
  withTable(folder, kTable);
  EXPECT_NEAR(moved(folder, "y", -90, 1), -1.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", -87.5, 1), -2.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", -87.5, 1), -15.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", 100, -1), -20.0, kNanometre);
}

TEST(HeidenhainInterpreter, TheColumnOfBacklashIsTheOtherDirection) {
  TableFolder folder;
  withTable(folder, kTable);
  EXPECT_NEAR(moved(folder, "y", -87.5, -1), -3.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", -87.5, 0), -2.5, kNanometre);
}

TEST(HeidenhainInterpreter, OnlyTheActiveLineCounts) {
  TableFolder folder;
  folder.file("config.cma", "BEGIN CONFIG.CMA\nNR ACTIVE Y\n0 - AXISY.COM\n[END]\n")
      .file("AXISY.COM", kTable);
  EXPECT_NEAR(moved(folder, "y", -90, 1), 0.0, kNanometre);
}

TEST(HeidenhainInterpreter, WhatTheControlDoesNotTakeIsRefused) {
  TableFolder many, falling, half, number;
  std::string table = "BEGIN AXISY.COM MM\nNR AXISPOS Y\n";
  for (int i = 0; i < 257; ++i) table += std::to_string(i) + " " + std::to_string(i) + " 0\n";
  EXPECT_THAT(refusal("heidenhain", withTable(many, table + "[END]\n")),
              AllOf(HasSubstr("axisy.com:259"), HasSubstr("256")));
  EXPECT_THAT(
      refusal("heidenhain", withTable(falling, "BEGIN AXISY.COM MM\nNR AXISPOS Y\n0 5 0\n1 5 0\n[END]\n")),
      AllOf(HasSubstr("axisy.com:4"), HasSubstr("AXISPOS: 5")));
  EXPECT_THAT(refusalOf("heidenhain", {{"config.cma", kAssignment}}),
              AllOf(HasSubstr("config.cma:3"), HasSubstr("AXISY.COM")));
  EXPECT_THAT(refusal("heidenhain", withTable(half, "BEGIN AXISY.COM MM\nNR AXISPOS Y\n0 5 0\n")),
              HasSubstr("[END]"));
  EXPECT_THAT(refusal("heidenhain", withTable(number, "BEGIN AXISY.COM MM\nNR AXISPOS Y\n0 5 1,5\n[END]\n")),
              AllOf(HasSubstr("axisy.com:3"), HasSubstr("'1,5' is not a number")));
}

TEST(HeidenhainInterpreter, OtherUnitsEmptyCellsAndRotaryAxesAreRefused) {
  TableFolder inch, empty;
  EXPECT_THAT(refusal("heidenhain", withTable(inch, "BEGIN AXISY.COM INCH\nNR AXISPOS Y\n0 5 0\n[END]\n")),
              AllOf(HasSubstr("axisy.com:1"), HasSubstr("unit 'INCH' is not read, only MM")));
  EXPECT_THAT(refusal("heidenhain", withTable(empty, "BEGIN AXISY.COM MM\nNR AXISPOS Y Z\n0 5 0\n[END]\n")),
              AllOf(HasSubstr("axisy.com:3"), HasSubstr("3 cells below 4 columns")));
  EXPECT_THAT(refusalOf("heidenhain", {{"config.cma", "BEGIN CONFIG.CMA\nNR ACTIVE C\n0 * C.COM\n[END]\n"},
                                       {"C.COM", kTable}}),
              AllOf(HasSubstr("config.cma:2"), HasSubstr("column C")));
  EXPECT_THAT(refusalOf("heidenhain", {{"config.cma", "BEGIN CONFIG.CMA\nNR X ACTIVE\n0 X.COM *\n[END]\n"}}),
              AllOf(HasSubstr("config.cma:2"), HasSubstr("NR and ACTIVE")));
}

}  // namespace
}  // namespace mm
