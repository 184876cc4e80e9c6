// From a file of each format to the parameter that was put into it.
#include <gtest/gtest.h>

#include <set>

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

// One reading a second, and a cycle of one second has the same value at each: it is no cause, and no
// obstacle.
TEST_F(ImportedFormats, WhatAPositioningTestMissesIsNamed) {
  parameter("iso230_2_x.csv", "");
  const nlohmann::json found =
      mmRun(folder_, "diagnose " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml" + " --json")
          .json();
  std::set<std::string> types;  // and not one drive that winds up over more than the travel
  for (const auto& missing : found["missing"]) types.insert(missing["effect"]["type"].get<std::string>());
  EXPECT_EQ(types, (std::set<std::string>{"backlash", "scale"})) << found["sentence"];
  EXPECT_LT(found["held_out_rms_with_found_um"].get<double>(), 0.12) << found["sentence"];
  for (const auto& cause : found["candidates"]) EXPECT_TRUE(cause["odds"].is_number()) << cause["in_words"];
}

TEST_F(ImportedFormats, SquarenessOfABallBar) {
  const auto p = parameter("ball_bar_xy.csv", "{type: squareness, axis: x, of: y}");
  EXPECT_NEAR(p[0]["value"].get<double>(), 100.0, 2.0) << p;  // urad
}

TEST_F(ImportedFormats, ABallBarIsReportedAsACircleOfTheStandard) {
  parameter("ball_bar_xy.csv", "");
  const std::string library = folder_.write("stub.js", "/* plotly */" + std::string(200000, ' '));
  const Answer made = mmRun(folder_, "report " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml" +
                                         " --plotly " + library + " -o " + folder_ / "bar.html");
  ASSERT_EQ(made.status, 0) << made.error;
  const std::string page = textOf(folder_ / "bar.html"), begin = "id=\"data\">";
  const std::size_t from = page.find(begin) + begin.size();
  const auto data = nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
  ASSERT_EQ(data["circles"].size(), 1u);
  EXPECT_EQ(data["circles"][0]["first"], "x");
  EXPECT_EQ(data["circles"][0]["second"], "y");
  EXPECT_NEAR(data["circles"][0]["radius_mm"].get<double>(), 14.0, 1e-3);
  EXPECT_NEAR(data["circles"][0]["measured"]["counter_clockwise"]["G"].get<double>(), 1.4, 0.1);
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

TEST_F(ImportedFormats, SummaryAsJson) {
  const std::string csv = folder_.write(
      "r.csv", "Zeit;X [mm];Abweichung X [µm]\n0;-16000;1,5\n10;0;2,5\n20;16000;3,5\nMittelwert;;2,5\n");
  const std::string to = " --machine three_axis -o " + folder_ / "r.bag" + " --json --force";
  const Answer read = mmRun(folder_, "import " + csv + to);
  ASSERT_EQ(read.status, 0) << read.error;
  const nlohmann::json object = read.json();
  EXPECT_EQ(object["format"], "table");
  ASSERT_EQ(object["columns"].size(), 3u);
  const nlohmann::json x = {{"name", "X [mm]"},      {"meaning", "reading of joint x"}, {"unit", "mm"},
                            {"unit_from", "header"}, {"range", {-16000., 16000.}},      {"first", "-16000"}};
  EXPECT_EQ(object["columns"][1], x);
  EXPECT_EQ(object["columns"][0]["unit_from"], "assumed");
  EXPECT_EQ(object["remarks"].size(), 2u) << object["remarks"];
  EXPECT_TRUE(object["faults"].empty());
  ASSERT_EQ(object["questions"].size(), 1u);
  EXPECT_NE(object["questions"][0]["question"].get<std::string>().find("divided by 1000"), std::string::npos);
  EXPECT_EQ(object["observations"], 3);
  EXPECT_EQ(object["written"], folder_ / "r.bag");

  const std::string bad = folder_.write("b.csv", "time_s;X [mm];Error X [um]\n0;1;1\n");
  const Answer refused = mmRun(folder_, "import " + bad + to);
  EXPECT_EQ(refused.status, 2);
  const nlohmann::json why = refused.json();
  ASSERT_EQ(why["faults"].size(), 1u);
  EXPECT_NE(refused.error.find(why["faults"][0].get<std::string>()), std::string::npos);
  EXPECT_TRUE(why["written"].is_null());
  EXPECT_TRUE(why["observations"].is_null());
}

TEST_F(ImportedFormats, QuestionsAreInTheSummary) {
  const std::string csv =
      folder_.write("r.csv", "time_s,x_mm,deviation_x_um\n0,-16000,1.5\n10,0,2.5\n20,16000,3.5\n");
  const Answer read = mmRun(folder_, "import " + csv + " --machine three_axis -o " + folder_ / "r.bag");
  ASSERT_EQ(read.status, 0) << read.error;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "r.bag"));
  EXPECT_NE(read.out.find("question: x is -16000 … 16000 mm, but the machine goes from -20 to 20 mm"),
            std::string::npos)
      << read.out;
}

TEST_F(ImportedFormats, APreviewWritesNothing) {
  const std::string asked = "import examples/import/iso230_2_x.csv --machine three_axis --preview";
  EXPECT_EQ(mmRun(folder_, asked + " -o " + folder_ / "p.bag").status, 2);
  const Answer text = mmRun(folder_, asked);
  ASSERT_EQ(text.status, 0) << text.error;
  EXPECT_NE(text.out.find("first rows\n  Target [mm]  1+"), std::string::npos) << text.out;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "p.bag"));
  const Answer object = mmRun(folder_, asked + " --json");
  ASSERT_EQ(object.status, 0) << object.error;
  EXPECT_EQ(object.json()["rows"].size(), 7u);
  EXPECT_TRUE(object.json()["written"].is_null());
  EXPECT_EQ(mmRun(folder_, "import examples/import/iso230_2_x.csv --machine three_axis").status, 2);
}

}  // namespace
}  // namespace mm
