#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// B-63980EN, page 100: reference at 40, travel -400 to 800 mm every 50 mm; increments of 33 to 49 as printed
// there
std::string linearExample(const std::string& more = "") {
  const int increments[] = {2, 1, 1, -2, 0, -1, 0, -1, 2, 1, 0, -1, -1, -2, 0, 1, 2};
  std::string text =
      "%\nN01020 A1 P88 A2 P89\nN03620 A1 P40\nN03621 A1 P33\nN03622 A1 P56\nN03623 A1 P1\nN03624 A1 "
      "P50000\n";
  for (int i = 0; i < 17; ++i)
    text += "N" + std::to_string(10033 + i) + " P" + std::to_string(increments[i]) + "\n";
  return text + more + "%\n";
}

double moved(const TableFolder& folder, double x, int direction = 1) {
  return addedMicrometres(*interpret("fanuc", folder.path()), atMillimetres({{"x", x}}, direction), "x");
}

TEST(FanucInterpreter, IncrementsAddUpFromTheReferenceBothWays) {
  TableFolder folder;
  folder.file("parameters.txt", linearExample());
  EXPECT_NEAR(moved(folder, 0), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, 50), 2.0, kNanometre);    // 41
  EXPECT_NEAR(moved(folder, 100), 3.0, kNanometre);   // 41, 42
  EXPECT_NEAR(moved(folder, 300), -1.0, kNanometre);  // 2 1 0 -1 -1 -2
  EXPECT_NEAR(moved(folder, -50), 1.0, kNanometre);   // less 40
  EXPECT_NEAR(moved(folder, -250), 4.0, kNanometre);  // less 40 to 36
  EXPECT_NEAR(moved(folder, -400), 0.0, kNanometre);  // less 40 to 33
  EXPECT_NEAR(moved(folder, 24), 0.0, kNanometre);    // in one step, in the middle of its section
  EXPECT_NEAR(moved(folder, 26), 2.0, kNanometre);
  EXPECT_NEAR(moved(folder, -26), 1.0, kNanometre);
  EXPECT_NEAR(moved(folder, 9000), 2.0, kNanometre);  // beyond the last point
  EXPECT_NEAR(moved(folder, -9000), 0.0, kNanometre);
}

TEST(FanucInterpreter, MagnificationAndDetectionUnitMultiply) {
  TableFolder folder;
  folder.file("parameters.txt", linearExample("N03623 A1 P10\nN01013 A1 P00000010\nN03624 A1 P50.0\n"));
  EXPECT_NEAR(moved(folder, 50), 2.0, kNanometre);  // 2 x 10 x 0.1 um
}

TEST(FanucInterpreter, WhatTheControlHasIsReadBesideWhatItIsGiven) {
  TableFolder folder;
  folder.file("parameters.txt", linearExample("N03624 A1 P50.0\nN01851 A1 P6\n"));
  folder.file("compare.txt", "%\nN01013 A1 P00000010\nN01820 A1 P4\n%\n");  // 0.1 um / 2
  EXPECT_NEAR(moved(folder, 50), 2 * 0.05, kNanometre);
  EXPECT_NEAR(moved(folder, 0, -1), -6 * 0.05, kNanometre);
  folder.file("compare.txt", "N01820 A1 P110\n");  // 1 um x 10
  EXPECT_NEAR(moved(folder, 50), 20.0, kNanometre);
  folder.file("compare.txt", "N01820 A1 P200\n");
  EXPECT_THAT(refusal("fanuc", folder),
              AllOf(HasSubstr("compare.txt:1"), HasSubstr("1820"), HasSubstr("200")));
}

TEST(FanucInterpreter, BacklashIsTakenUpBackwards) {
  TableFolder folder;
  folder.file("parameters.txt", "N01851 A1 P12\n");
  EXPECT_NEAR(moved(folder, 5, 1), 0.0, kNanometre);
  EXPECT_NEAR(moved(folder, 5, -1), -12.0, kNanometre);
}

TEST(FanucInterpreter, RotaryAxesTablesOfEachDirectionAndAnotherReferenceAreRefused) {
  const std::pair<const char*, const char*> lines[] = {
      {"N01020 A1 P67\n", "rotary axes are not read"},
      {"N01006 A1 P00000001\n", "rotary axes are not read"},
      {"N03605 A1 P00000001\n", "a table for each direction"},
      {"N01240 A1 P5.0\n", "5.0 is not read, only 0"}};
  for (const auto& [line, why] : lines) {
    EXPECT_THAT(refusalOf("fanuc", {{"parameters.txt", linearExample(line)}}),
                AllOf(HasSubstr("parameters.txt:"), HasSubstr(why)))
        << line;
  }
}

TEST(FanucInterpreter, WhatIsOutOfRangeIsRefused) {
  EXPECT_THAT(refusalOf("fanuc", {{"parameters.txt", linearExample("N10041 P8\n")}}),
              AllOf(HasSubstr("parameters.txt:25"), HasSubstr("10041"), HasSubstr("-7 to 7")));
  EXPECT_THAT(refusalOf("fanuc", {{"parameters.txt", linearExample("N03622 A1 P1024\n")}}),
              AllOf(HasSubstr("3622"), HasSubstr("0 to 1023")));
  EXPECT_THAT(refusalOf("fanuc", {{"parameters.txt", "N03620 A1 X40\n"}}),
              AllOf(HasSubstr("parameters.txt:1"), HasSubstr("X40")));
  EXPECT_THAT(refusalOf("fanuc", {{"parameters.txt", linearExample("N03620 A1 P90\n")}}),
              AllOf(HasSubstr("3620"), HasSubstr("90")));
}

}  // namespace
}  // namespace mm
