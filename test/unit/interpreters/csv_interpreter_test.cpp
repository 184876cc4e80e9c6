#include "interpreter_support.h"

namespace mm {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string chain(const std::string& about) {
  return "# workpiece, x, y, z, tip\n"
         "joint,kind,direction_x,direction_y,direction_z,origin_x_mm,origin_y_mm,origin_z_mm,rotation_about\n"
         "x,linear,1,0,0,0,0,0," +
         about + "\ny,linear,0,1,0,0,0,0," + about + "\nz,linear,0,0,1,0,0,0," + about +
         "\ntip,,,,,0,0,-50,\n";
}

double moved(const TableFolder& folder, const std::string& joint, double x, double y, double z,
             int direction = 1) {
  return addedMicrometres(*interpret("csv", folder.path()),
                          atMillimetres({{"x", x}, {"y", y}, {"z", z}}, direction), joint);
}

constexpr double kSecondOrder = 0.01;  // um

TEST(CsvInterpreter, ADeviationIsTakenOffByDirection) {
  TableFolder folder;
  folder.file("chain.csv", chain("fixed_side"))
      .file("EXX.csv", "position_mm,positive_um,negative_um\n0,0,4\n100,10,12\n")
      .file("EYX.csv", "position_mm,value_um\n0,2\n100,2\n");
  EXPECT_NEAR(moved(folder, "x", 50, 0, 0, 1), -5.0, kSecondOrder);
  EXPECT_NEAR(moved(folder, "x", 50, 0, 0, -1), -8.0, kSecondOrder);
  EXPECT_NEAR(moved(folder, "x", 500, 0, 0, 1), -10.0, kSecondOrder);
  EXPECT_NEAR(moved(folder, "y", 50, 0, 0, 1), -2.0, kSecondOrder);
  EXPECT_NEAR(moved(folder, "z", 50, 0, 0, 1), 0.0, kSecondOrder);
}

// A yaw of 10 urad displaces the tip by the rotation times its distance from the fixed side, the whole
// (100, 200, 250) mm.
TEST(CsvInterpreter, AnAngleCountsByItsLeverFromTheFixedSide) {
  TableFolder fixed;
  fixed.file("chain.csv", chain("fixed_side")).file("ECX.csv", "position_mm,value_urad\n0,10\n1000,10\n");
  EXPECT_NEAR(moved(fixed, "x", 100, 200, 300), 2.0, kSecondOrder);
  EXPECT_NEAR(moved(fixed, "y", 100, 200, 300), -1.0, kSecondOrder);
}

TEST(CsvInterpreter, TheToolIsTheLeverOfTheLastAxis) {
  TableFolder folder;
  folder.file("chain.csv", chain("fixed_side")).file("EBZ.csv", "position_mm,value_urad\n0,20\n");
  // about +y by 20 urad: x of a point 40 mm below moves by -0.8 um
  EXPECT_NEAR(moved(folder, "x", 0, 0, 10), 0.8, kSecondOrder);
}

TEST(CsvInterpreter, ARotaryJointOfTheChainStaysAndTurnsWhatFollows) {
  TableFolder folder;
  folder
      .file("chain.csv",
            "joint,kind,direction_x,direction_y,direction_z,origin_x_mm,origin_y_mm,origin_z_mm,rotation_"
            "about\n"
            "c,rotary,0,0,1,0,0,0,fixed_side\nx,linear,1,0,0,0,0,0,fixed_side\ny,linear,0,1,0,0,0,0,fixed_"
            "side\n"
            "tip,,,,,0,0,0,\n")
      .file("EYX.csv", "position_mm,value_um\n0,3\n100,3\n");
  CommandedState command = atMillimetres({{"x", 50.0}, {"y", 0.0}});
  command.position["c"] = 0.5;
  const auto motors = interpret("csv", folder.path())->motors(command);
  EXPECT_EQ(motors.at("c"), 0.5);
  EXPECT_NEAR(motors.at("y"), -3e-6, 1e-9);
  EXPECT_NEAR(motors.at("x"), 0.05, 1e-9);
}

TEST(CsvInterpreter, WhatIsNotStatedIsRefused) {
  TableFolder joint;
  EXPECT_THAT(refusalOf("csv", {{"EXX.csv", "position_mm,value_um\n0,1\n"}}), HasSubstr("chain.csv"));
  EXPECT_THAT(
      refusalOf("csv", {{"chain.csv", chain("fixed_side")}, {"EXA.csv", "position_deg,value_um\n0,1\n"}}),
      AllOf(HasSubstr("EXA.csv"), HasSubstr("joint 'a'")));
  EXPECT_THAT(
      refusalOf("csv", {{"chain.csv", chain("fixed_side")}, {"EXX.csv", "position_mm,value_um\n5,1\n5,2\n"}}),
      AllOf(HasSubstr("EXX.csv:3"), HasSubstr("position_mm: 5")));
  EXPECT_THAT(
      refusalOf("csv", {{"chain.csv", chain("fixed_side")}, {"EAX.csv", "position_mm,value_um\n0,1\n"}}),
      AllOf(HasSubstr("EAX.csv:1"), HasSubstr("value_urad")));
  EXPECT_THAT(refusalOf("csv", {{"chain.csv", chain("carriage")}}),
              AllOf(HasSubstr("chain.csv:3"), HasSubstr("'carriage' is not read, only fixed_side")));
}

}  // namespace
}  // namespace mm
