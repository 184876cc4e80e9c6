#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// As in TF5280, "Updating the Volumetric Compensation".
const char* const kIsgList =
    "workpiece_axes           0\nX                        1\nY                        2\nZ                  "
    "      3\n"
    "Interpolation            GRID # linear\nenable_splicing          FALSE\nfilter_steps             20\n"
    "file[0]                  C:\\vc\\volcomp1.csv\nfile_format[0]           ISG_CSV\n";
const char* const kIsgTable =
    "X Y Z EXX EYY\n0 0 0 0.000 0.000\n0 5 0 0.001 0.001\n0 10 0 0.002 0.002\n0 15 0 0.003 0.003\n";

std::map<std::string, std::string> isgFolder(const std::string& table, const std::string& more = "") {
  return {{"volcomp.lis", kIsgList + more}, {"volcomp1.csv", table}};
}

double moved(const std::map<std::string, std::string>& files, const std::string& joint, double x, double y,
             double z, int direction = 1) {
  const TableFolder folder(files);
  return addedMicrometres(*interpret("isg", folder.path()),
                          atMillimetres({{"x", x}, {"y", y}, {"z", z}}, direction), joint);
}

TEST(IsgInterpreter, ErrorsOfTheDocumentedTableAreTakenOff) {
  const auto files = isgFolder(kIsgTable);
  for (const int direction : {-1, 0, 1}) {
    EXPECT_NEAR(moved(files, "x", 7.0, 12.5, 3.0, direction), -2.5, kNanometre);
    EXPECT_NEAR(moved(files, "y", 7.0, 12.5, 3.0, direction), -2.5, kNanometre);
    EXPECT_NEAR(moved(files, "z", 7.0, 12.5, 3.0, direction), 0.0, kNanometre);
  }
  EXPECT_NEAR(moved(files, "x", 0.0, 99.0, 0.0), -3.0, kNanometre);
  EXPECT_NEAR(moved(files, "x", 0.0, -99.0, 0.0), 0.0, kNanometre);
}

TEST(IsgInterpreter, ErrorsAlongOneDirectionAddUpOverBlocks) {
  // Linear between the four points around a place, in whatever order the records stand.
  const auto files = isgFolder(
      "// of X\nX EXX\n0 0.001\n10 0.003 // the end\n#\nEXY Y X\n0.004 10 10\n0 0 0\n0 0 10\n0 10 0\n"
      "#\nEZZ\n0.006\n");
  EXPECT_NEAR(moved(files, "x", 0.0, 10.0, 0.0), -1.0, kNanometre);
  EXPECT_NEAR(moved(files, "x", 10.0, 10.0, 0.0), -3.0 - 4.0, kNanometre);
  EXPECT_NEAR(moved(files, "x", 5.0, 5.0, 0.0), -2.0 - 1.0, kNanometre);
  EXPECT_NEAR(moved(files, "z", 5.0, 5.0, 0.0), -6.0, kNanometre);
}

TEST(IsgInterpreter, TheListTurnsAxesRoundAndLeavesThemOut) {
  const auto files = isgFolder(kIsgTable, "negate X\nset_to_zero YZ\n");
  EXPECT_NEAR(moved(files, "x", 0.0, 10.0, 0.0), 2.0, kNanometre);
  EXPECT_NEAR(moved(files, "y", 0.0, 10.0, 0.0), 0.0, kNanometre);
}

TEST(IsgInterpreter, PointsAreThoseOfItsGrids) {
  const TableFolder folder(isgFolder("X Z EYX\n0 0 0\n0 5 0.001\n10 0 0\n10 5 0\n#\nY EZY\n0 0\n10 0\n"));
  const JointPoints points = interpret("isg", folder.path())->points();
  ASSERT_EQ(points.size(), 3u);  // EZY is zero
  EXPECT_TRUE(points.at("y").empty());
  ASSERT_EQ(points.at("z").size(), 2u);
  EXPECT_NEAR(points.at("z")[1], 0.005, 1e-12);
}

TEST(IsgInterpreter, WhatHasNoDocumentedRuleIsRefused) {
  const auto table = [](const std::string& text) { return refusalOf("isg", isgFolder(text)); };
  const auto list = [](const std::string& more) { return refusalOf("isg", isgFolder(kIsgTable, more)); };
  EXPECT_THAT(table("X EXX EAX\n0 0 0\n1 0 0\n"),
              AllOf(HasSubstr("volcomp1.csv:1"), HasSubstr("column EAX")));
  EXPECT_THAT(table("X Y EXX\n0 0 0\n0 1 0\n1 0 0\n"),
              AllOf(HasSubstr("not on a grid"), HasSubstr("3 instead of 4")));
  EXPECT_THAT(table("X EXX\n0 0\n1 0\n1 0.5\n"), AllOf(HasSubstr("volcomp1.csv:4"), HasSubstr("already")));
  EXPECT_THAT(table("X EXX\n0 0\n#\nY EXX\n0 0\n"), AllOf(HasSubstr("volcomp1.csv:4"), HasSubstr("twice")));
  EXPECT_THAT(table("X EXX\n0 none\n"), AllOf(HasSubstr("volcomp1.csv:2"), HasSubstr("'none'")));
  EXPECT_THAT(table("X EXX\n"), HasSubstr("no records"));
  EXPECT_THAT(table("// nothing\n"), HasSubstr("no header"));
  EXPECT_THAT(list("alternative_model 1\n"), HasSubstr("only 0"));
  EXPECT_THAT(list("workpiece_axes 1\n"), AllOf(HasSubstr("volcomp.lis:10"), HasSubstr("only 0")));
  EXPECT_THAT(list("interpolation SCATTER\n"), AllOf(HasSubstr("SCATTER"), HasSubstr("GRID")));
  EXPECT_THAT(list("chain CBYXZ\n"), AllOf(HasSubstr("chain: CBYXZ"), HasSubstr("XYZ")));
  EXPECT_THAT(list("file_format[0] ETALON_EXCHANGE\n"), HasSubstr("only ISG_CSV"));
  EXPECT_THAT(list("negat X\n"), AllOf(HasSubstr("'negat'"), HasSubstr("did you mean 'negate'")));
  EXPECT_THAT(list("negate A\n"), HasSubstr("'A' is no set of X, Y and Z"));
  EXPECT_THAT(list("z 1\n"), AllOf(HasSubstr("z: 1"), HasSubstr("of x, too")));
  EXPECT_THAT(list("file[1] C:\\vc\\other.csv\n"), HasSubstr("other.csv"));
}

}  // namespace
}  // namespace mm
