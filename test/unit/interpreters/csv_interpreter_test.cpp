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

// A yaw of 10 urad displaces the tip by the rotation times its distance from where it turns: about the fixed
// side that is the whole (100, 200, 250) mm, about the carriage without the way of x.
TEST(CsvInterpreter, AnAngleCountsByItsLeverFromTheStatedPoint) {
  TableFolder fixed, carriage;
  const std::string yaw = "position_mm,value_urad\n0,10\n1000,10\n";
  fixed.file("chain.csv", chain("fixed_side")).file("ECX.csv", yaw);
  EXPECT_NEAR(moved(fixed, "x", 100, 200, 300), 2.0, kSecondOrder);
  EXPECT_NEAR(moved(fixed, "y", 100, 200, 300), -1.0, kSecondOrder);
  carriage.file("chain.csv", chain("carriage")).file("ECX.csv", yaw);
  EXPECT_NEAR(moved(carriage, "x", 100, 200, 300), 2.0, kSecondOrder);
  EXPECT_NEAR(moved(carriage, "y", 100, 200, 300), 0.0, kSecondOrder);
}

TEST(CsvInterpreter, TheToolIsTheLeverOfTheLastAxis) {
  TableFolder folder;
  folder.file("chain.csv", chain("carriage")).file("EBZ.csv", "position_mm,value_urad\n0,20\n");
  // about +y by 20 urad: x of a point 50 mm below moves by -1 um
  EXPECT_NEAR(moved(folder, "x", 0, 0, 10), 1.0, kSecondOrder);
}

TEST(CsvInterpreter, SquarenessIsTheOrientationOfAnAxis) {
  TableFolder folder;
  folder.file("chain.csv", chain("fixed_side"))
      .file("location.csv", "error,value_um,value_urad\nC0Y,,50\nCOY,,50\n");
  EXPECT_NEAR(moved(folder, "x", 0, 100, 0), 10.0, kSecondOrder);
  EXPECT_NEAR(moved(folder, "y", 0, 100, 0), 0.0, kSecondOrder);
}

TEST(CsvInterpreter, ARotaryMotorTakesItsOwnAngle) {
  TableFolder folder;
  folder
      .file("chain.csv",
            "joint,kind,direction_x,direction_y,direction_z,origin_x_mm,origin_y_mm,origin_z_mm,rotation_"
            "about\n"
            "c,rotary,0,0,-1,0,0,0,fixed_side\nx,linear,1,0,0,0,0,0,fixed_side\ntip,,,,,0,0,0,\n")
      .file("ECC.csv", "position_deg,value_urad\n0,100\n360,100\n");
  CommandedState command = atMillimetres({{"x", 100.0}});
  command.position["c"] = 0.5;
  const auto motors = interpret("csv", folder.path())->motors(command);
  // the axis points down: its positive turn is a negative one about z
  EXPECT_NEAR(motors.at("c"), 0.5 + 100e-6, 1e-9);
  EXPECT_NEAR(motors.at("x"), 0.1, 1e-9);
}

TEST(CsvInterpreter, WhatIsNotStatedIsRefused) {
  TableFolder none, joint, falling, unit, side, location;
  none.file("EXX.csv", "position_mm,value_um\n0,1\n");
  EXPECT_THAT(refusal("csv", none), HasSubstr("chain.csv"));
  joint.file("chain.csv", chain("carriage")).file("EXA.csv", "position_deg,value_um\n0,1\n");
  EXPECT_THAT(refusal("csv", joint), AllOf(HasSubstr("EXA.csv"), HasSubstr("joint 'a'")));
  falling.file("chain.csv", chain("carriage")).file("EXX.csv", "position_mm,value_um\n5,1\n5,2\n");
  EXPECT_THAT(refusal("csv", falling), AllOf(HasSubstr("EXX.csv:3"), HasSubstr("position_mm: 5")));
  unit.file("chain.csv", chain("carriage")).file("EAX.csv", "position_mm,value_um\n0,1\n");
  EXPECT_THAT(refusal("csv", unit), AllOf(HasSubstr("EAX.csv:1"), HasSubstr("value_urad")));
  side.file("chain.csv", chain("moving_side"));
  EXPECT_THAT(refusal("csv", side), AllOf(HasSubstr("chain.csv:3"), HasSubstr("moving_side")));
  location.file("chain.csv", chain("carriage")).file("location.csv", "error,value_um,value_urad\nC0Y,3,\n");
  EXPECT_THAT(refusal("csv", location), AllOf(HasSubstr("location.csv:2"), HasSubstr("C0Y is an angle")));
}

}  // namespace
}  // namespace mm
