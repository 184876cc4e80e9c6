#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// As in P-COMP "Example of a compensation value list": errors of -102 and 80 (0.1 um) in the positive and
// the negative direction, every 66.7 um
const char* const kExample =
    "kopf.log_achs_nr                     2\nkopf.log_achs_name                   Y-ACHSE\nkw.ssfk.interval "
    "667\n"
    "kw.ssfk.kw_startpos                 -200000\nkw.ssfk.kw_nr_max 4\nkw.ssfk.unit 1\nkw.ssfk.bilateral 1 # "
    "both ways\n"
    "kw.ssfk.table[0].pos 0\nkw.ssfk.table[1].pos 24\nkw.ssfk.table[2].pos -102\n"
    "kw.ssfk.table[0].neg 0\nkw.ssfk.table[1].neg 67\nkw.ssfk.table[2].neg 80\n";

double moved(const TableFolder& folder, const std::string& joint, std::map<std::string, double> position,
             int direction = 1) {
  return addedMicrometres(*interpret("beckhoff", folder.path()), atMillimetres(position, direction), joint);
}

TEST(BeckhoffInterpreter, ErrorsOfTheDocumentedListAreTakenOff) {
  TableFolder folder;
  folder.file("y.lis", kExample);
  EXPECT_NEAR(moved(folder, "y", {{"y", -19.8666}}, 1), 10.2, kNanometre);
  EXPECT_NEAR(moved(folder, "y", {{"y", -19.8666}}, -1), -8.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", {{"y", (-19.9333 - 19.8666) / 2.0}}, 1), 3.9, kNanometre);
  EXPECT_NEAR(moved(folder, "y", {{"y", -25.0}}, 1), 0.0, kNanometre);
}

TEST(BeckhoffInterpreter, AListThatIsSwitchedOffDoesNothing) {
  TableFolder folder;
  folder.file("y.lis", kExample)
      .file("y.axis.lis", "lr_param.ssfk 0\ngetriebe[0].lose 50\nlr_param.anwahl_losekomp 1\n");
  EXPECT_NEAR(moved(folder, "y", {{"y", -19.8666}}, 1), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, "y", {{"y", -19.8666}}, -1), -5.0, kNanometre);  // backlash
}

TEST(BeckhoffInterpreter, CrossCompensationAddsByTheMaster) {
  TableFolder folder;
  folder.file(
      "z.lis",
      "kopf.log_achs_nr 3\nkw.crosscomp.unit 1\nkw.crosscomp.master_ax_nr 1\nkw.crosscomp.last_index 1\n"
      "kw.crosscomp.table[0].setpoint 0\nkw.crosscomp.table[0].correction 0\n"
      "kw.crosscomp.table[1].setpoint 1000000\nkw.crosscomp.table[1].correction 200\n");
  EXPECT_NEAR(moved(folder, "z", {{"x", 50.0}, {"z", 0.0}}), 10.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", {{"x", 500.0}, {"z", 0.0}}), 20.0, kNanometre);
}

TEST(BeckhoffInterpreter, APlaneIsLinearBetweenFourPointsAndKeepsItsMargin) {
  TableFolder folder;
  folder.file(
      "z.lis",
      "kopf.log_achs_nr 3\nkw.crosscomp2.unit 1\nkw.crosscomp2.interval 1000000\n"
      "kw.crosscomp2.last_index_master1 1\nkw.crosscomp2.last_index_master2 "
      "1\nkw.crosscomp2.start_position_master1 0\n"
      "kw.crosscomp2.start_position_master2 0\nkw.crosscomp2.master1_ax_nr 1\nkw.crosscomp2.master2_ax_nr 2\n"
      "kw.crosscomp2.table[0][1].correction 100\nkw.crosscomp2.table[1][0].correction 200\n"
      "kw.crosscomp2.table[1][1].correction 400\n");
  EXPECT_NEAR(moved(folder, "z", {{"x", 100.0}, {"y", 0.0}, {"z", 0.0}}), 10.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", {{"x", 0.0}, {"y", 100.0}, {"z", 0.0}}), 20.0, kNanometre);
  EXPECT_NEAR(moved(folder, "z", {{"x", 50.0}, {"y", 50.0}, {"z", 0.0}}), 17.5, kNanometre);
  EXPECT_NEAR(moved(folder, "z", {{"x", 900.0}, {"y", 900.0}, {"z", 0.0}}), 40.0, kNanometre);
}

TEST(BeckhoffInterpreter, WhatTheControllerDoesNotLoadIsRefused) {
  EXPECT_THAT(
      refusalOf("beckhoff", {{"z.lis",
                              "kw.crosscomp.unit 1\nkw.crosscomp.master_ax_nr 1\nkw.crosscomp.last_index 1\n"
                              "kw.crosscomp.table[0].setpoint 5\nkw.crosscomp.table[1].setpoint 5\n"}}),
      AllOf(HasSubstr("z.lis:5"), HasSubstr("setpoint 1 is not above")));
  EXPECT_THAT(refusalOf("beckhoff", {{"y.lis", std::string(kExample) + "kw.ssfk.kw_nr_max 1500\n"}}),
              AllOf(HasSubstr("y.lis:14"), HasSubstr("kw.ssfk.kw_nr_max: 1500"), HasSubstr("1499")));
  EXPECT_THAT(refusalOf("beckhoff", {{"y.lis", "kw.ssfk.tabel[0].pos 1\n"}}),
              AllOf(HasSubstr("y.lis:1"), HasSubstr("kw.ssfk.tabel[0].pos")));
  EXPECT_THAT(refusalOf("beckhoff", {{"x.csv", "Position,Compensation\n0,0\n10,0\n"}}),
              HasSubstr("has no <axis>.lis"));
  EXPECT_THAT(refusalOf("beckhoff", {{"z.lis", "kw.crosscomp.unit 1\nkw.crosscomp.master_ax_nr 17\n"}}),
              AllOf(HasSubstr("z.lis:2"), HasSubstr("axis 17")));
}

TEST(BeckhoffInterpreter, ParametersOfWhichNoRuleIsKnownAreRefused) {
  const std::pair<const char*, const char*> lines[] = {
      {"kw.ssfk.unit 0", "kw.ssfk.unit: 0 is not read, only 1"},
      {"kw.ssfk.modulo 1", "1 is not read, only 0"},
      {"kw.ssfk.interval 0", "kw.ssfk.interval: is not above 0"},
      {"kw.ssfk.table[1].setpoint 5", "is not read"},
      {"kw.ssfk.max_points 9", "is not read"}};
  for (const auto& [line, why] : lines) {
    EXPECT_THAT(refusalOf("beckhoff", {{"y.lis", std::string(kExample) + line + "\n"}}),
                AllOf(HasSubstr("y.lis:14: "), HasSubstr(why)))
        << line;
  }
}

}  // namespace
}  // namespace mm
