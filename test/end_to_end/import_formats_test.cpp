// From a file of each format to the parameter that was put into it.
#include <gtest/gtest.h>

#include "run_mm.h"

namespace mm {
namespace {

class ImportedFormats : public ::testing::Test {
 protected:
  /// Imports an example and fits one effect. @return its first parameter.
  nlohmann::json parameter(const std::string& file, const std::string& effects,
                           const std::string& machine = "three_axis") {
    const Answer imported = mmRun(folder_, "import examples/import/" + file + " --machine " + machine +
                                               " -o " + folder_ / "s.bag" + " --force");
    EXPECT_EQ(imported.status, 0) << imported.error;
    const std::string model =
        folder_.write("m.yaml", "machine: " + machine + "\neffects: [" + effects + "]\n");
    const Answer fitted = mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + model + " -o " +
                                             folder_ / "c.yaml" + " --method least_squares --json --force");
    EXPECT_EQ(fitted.status, 0) << fitted.error;
    return fitted.json()["parameters"];
  }
  TestFolder folder_;
};

TEST_F(ImportedFormats, PlayAndScaleOfAPositioningTest) {
  const auto p = parameter("iso230_2_x.csv", "{type: scale, axis: x}, {type: backlash, axis: x}");
  EXPECT_NEAR(p[0]["value"].get<double>(), 20.0, 3.0) << p;  // um/m
  EXPECT_NEAR(p[1]["value"].get<double>(), 4.0, 0.15) << p;  // um: the directions survive the bag
}

TEST_F(ImportedFormats, SquarenessOfABallBar) {
  const auto p = parameter("ball_bar_xy.csv", "{type: squareness, axis: x, of: y}");
  EXPECT_NEAR(p[0]["value"].get<double>(), 100.0, 2.0) << p;  // urad
}

TEST_F(ImportedFormats, SeatOfARotaryAxisInAnRTest) {
  const auto p =
      parameter("r_test_ba.csv", "{type: rotary_axis_offset, joint: a, direction: x}", "five_axis");
  EXPECT_NEAR(p[0]["value"].get<double>(), 12.0, 0.3) << p;  // um
}

TEST_F(ImportedFormats, ScalesOfAStepGaugeAndOfLengthBars) {
  EXPECT_NEAR(parameter("step_gauge_x.txt", "{type: scale, axis: x}")[0]["value"].get<double>(), 100.0, 8.0);
  EXPECT_NEAR(parameter("length_bars_y.csv", "{type: scale, axis: y}")[0]["value"].get<double>(), 40.0, 5.0);
}

}  // namespace
}  // namespace mm
