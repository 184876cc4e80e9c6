// What is missing, mistyped or misnamed in a session, through `mm`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "plate_rows.h"
#include "run_mm.h"
#include "shared_data.h"

namespace mm {
namespace {

using test::PlateRow;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

class Inputs : public ::testing::Test {
 protected:
  /// Imports rows as plate.csv. @return what import said.
  std::string import(const std::vector<PlateRow>& rows, bool velocities, const std::string& bag = "s.bag") {
    const std::string artifact = folder_.write("plate.yaml", test::plateArtifact());
    const Answer answer =
        mmRun(folder_, "import " + folder_.write("plate.csv", test::plateCsv(rows, velocities)) +
                           " --artifact " + artifact + " --machine three_axis -o " + folder_ / bag);
    EXPECT_EQ(answer.status, 0) << answer.error;
    return answer.out;
  }
  std::string model(const std::string& effects) {
    return folder_.write("m.yaml", "machine: three_axis\neffects: [" + effects + "]\n");
  }
  Answer calibrate(const std::string& effects, const std::string& bag = "s.bag",
                   const std::string& more = "--json") {
    const Answer answer =
        mmRun(folder_, "calibrate " + folder_ / bag + " --model " + model(effects) + " -o " +
                           folder_ / "c.yaml" + " --force --method least_squares " + more);
    EXPECT_EQ(answer.status, 0) << answer.error;
    return answer;
  }
  nlohmann::json check(const std::string& bag = "s.bag") {
    const Answer answer = mmRun(folder_, "check " + folder_ / bag + " --json");
    EXPECT_EQ(answer.status, 0) << answer.error;
    return answer.json();
  }
  static bool cannotShow(const nlohmann::json& set, const std::string& type) {
    for (const auto& c : set["cannot_show"])
      if (c["effect"]["type"] == type) return true;
    return false;
  }
  static double gapOf(const nlohmann::json& result, double& std) {
    for (const auto& p : result["parameters"])
      if (p["name"] == "gap") return std = p["std"].get<double>(), p["value"].get<double>();
    return std = NAN;
  }
  TestFolder folder_;
};

/// The plan of the plate, velocities not recorded, with play of x.
TEST_F(Inputs, ASimulatedPlateWithoutVelocitiesShowsItsPlay) {
  std::string plan = textOf("config/plans/nine_ball_plate.yaml");
  const std::string noise = "noise: {repeatability_um: 0.3, temperature_K: 0.02}";
  ASSERT_NE(plan.find(noise), std::string::npos);
  plan.replace(plan.find(noise), noise.size(),
               "noise: {repeatability_um: 0.3, temperature_K: 0.02, missing_velocities: 1}");
  const Answer simulated =
      mmRun(folder_, "simulate --machine three_axis --plan " + folder_.write("plan.yaml", plan) +
                         " --hide backlash:x=3um --seed 5 -o " + folder_ / "s.bag");
  ASSERT_EQ(simulated.status, 0) << simulated.error;
  const nlohmann::json set = check();
  EXPECT_FALSE(cannotShow(set, "backlash"));
  EXPECT_TRUE(cannotShow(set, "speed_lag")) << "speeds are not made up";
  ASSERT_FALSE(set["assumed"].empty());
  EXPECT_EQ(set["assumed"][0]["input"], "direction of travel of x");
  EXPECT_EQ(set["assumed"][0]["how"], "from the approach of the contact");
  EXPECT_GT(set["assumed"][0]["share"].get<double>(), 0.9);
  EXPECT_EQ(set["joints"][0]["travel"]["unknown"], 0);

  const Answer answer = calibrate("{type: backlash, axis: x}");
  double std = 0.0;
  EXPECT_NEAR(gapOf(answer.json(), std), 3.0, 0.15);
  EXPECT_LT(std, 0.05);
  EXPECT_EQ(answer.json()["assumed"], set["assumed"]);
  EXPECT_LT(answer.json()["chi2_per_dof"].get<double>(), 1.3);
  EXPECT_THAT(calibrate("{type: backlash, axis: x}", "s.bag", "").out,
              HasSubstr("assumed, where no motion was recorded: direction of travel\n  from the approach of "
                        "the contact (x in "));
}

TEST_F(Inputs, AnImportedPlateWithoutVelocitiesShowsItsPlay) {
  EXPECT_THAT(import(test::plateRows(3e-3), false), HasSubstr("assumed, where no motion was recorded"));
  double std = 0.0;
  const std::string effects = "{type: backlash, axis: x}, {type: scale, axis: x}";
  EXPECT_NEAR(gapOf(calibrate(effects).json(), std), 3.0, 0.15);
  EXPECT_THAT(import(test::plateRows(3e-3), true), Not(HasSubstr("assumed")));
  const Answer known = calibrate(effects);
  EXPECT_NEAR(gapOf(known.json(), std), 3.0, 0.15);
  EXPECT_TRUE(known.json()["assumed"].empty());
}

/// x = -12.364 entered as -1236.4 in one of 675 rows: not a digit of the result moves, nor the range.
TEST_F(Inputs, OneMistypedRowMovesNothing) {
  std::vector<PlateRow> rows = test::plateRows();
  std::vector<PlateRow> without = rows;
  const std::size_t typed = 300;
  without.erase(without.begin() + typed);
  rows[typed].position.x() *= 100.0;
  const std::string effects =
      "{type: scale, axis: x}, {type: positioning_polynomial, axis: x, degree: 2}, {type: backlash, axis: x}";
  import(without, true);
  const nlohmann::json right = calibrate(effects).json();
  const std::string domain = textOf(folder_ / "c.yaml");
  EXPECT_THAT(import(rows, true),
              AllOf(HasSubstr("line 302 of plate.csv"), HasSubstr("the row is set aside: x = ")));
  const Answer answer = calibrate(effects);
  const nlohmann::json result = answer.json();
  ASSERT_EQ(result["parameters"].size(), right["parameters"].size());
  for (std::size_t i = 0; i < right["parameters"].size(); ++i) {
    const double expected = right["parameters"][i]["value"].get<double>();
    EXPECT_NEAR(result["parameters"][i]["value"].get<double>(), expected, 1e-9 * std::abs(expected));
  }
  const auto rangeOf = [](const std::string& yaml) {
    const std::size_t begin = yaml.find("joints"), end = yaml.find("sensors", begin);
    return yaml.substr(begin, end - begin);
  };
  EXPECT_FALSE(rangeOf(domain).empty());
  EXPECT_EQ(rangeOf(textOf(folder_ / "c.yaml")), rangeOf(domain));
  ASSERT_EQ(result["set_aside"].size(), 1u);
  EXPECT_EQ(result["set_aside"][0]["row"], 302);
  EXPECT_EQ(result["set_aside"][0]["where"], "line 302 of plate.csv");
  EXPECT_EQ(result["set_aside"][0]["field"], "x");
  EXPECT_THAT(answer.error, AllOf(HasSubstr("warning"), HasSubstr("line 302 of plate.csv"),
                                  HasSubstr("all others are within")));
  EXPECT_EQ(check()["set_aside"], result["set_aside"]);
  EXPECT_THAT(mmRun(folder_, "compare " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml").error,
              HasSubstr("line 302 of plate.csv"));
}

TEST_F(Inputs, OutliersAreNamedByTheirLine) {
  std::vector<PlateRow> rows = test::plateRows();
  rows[99].position += 0.03 * Eigen::Vector3d(1, 1, 1);
  import(rows, true);
  const Answer answer = calibrate("{type: scale, axis: x}");
  ASSERT_EQ(answer.json()["outliers"].size(), 1u) << answer.out;
  EXPECT_EQ(answer.json()["outliers"][0]["row"], 101);
  EXPECT_EQ(answer.json()["outliers"][0]["where"], "line 101 of plate.csv");
  EXPECT_THAT(calibrate("{type: scale, axis: x}", "s.bag", "").out,
              HasSubstr("line 101 of plate.csv   residual"));
}

TEST_F(Inputs, QuestionsComeFirst) {
  std::vector<PlateRow> rows = test::plateRows();
  for (PlateRow& r : rows) {
    r.position /= 25.4;
    r.bed += 273.15;
  }
  import(rows, true);
  const nlohmann::json set = check();
  ASSERT_EQ(set["questions"].size(), 2u);
  EXPECT_THAT(set["questions"][0]["question"].get<std::string>(), HasSubstr("is it kelvin?"));
  EXPECT_TRUE(set["questions"][0]["before_um"].is_null());
  EXPECT_THAT(set["questions"][1]["question"].get<std::string>(), HasSubstr("are they in inches?"));
  EXPECT_GT(set["questions"][1]["before_um"].get<double>(), 5000.0);
  EXPECT_LT(set["questions"][1]["after_um"].get<double>(), 5.0);
  EXPECT_EQ(mmRun(folder_, "check " + folder_ / "s.bag").out.rfind("Questions first\ntemperature bed is ", 0),
            0u);
  const Answer answer = mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + model("") + " -o " +
                                           folder_ / "c.yaml" + " --method least_squares --json");
  EXPECT_THAT(answer.error, HasSubstr("mm: question: with x_mm, y_mm, z_mm in inches"));
  EXPECT_EQ(answer.json()["questions"], set["questions"]);
  EXPECT_THAT(mmRun(folder_, "diagnose " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml").error,
              HasSubstr("mm: question: temperature bed is"));

  rows = test::plateRows();
  for (PlateRow& r : rows)
    if (r.feature == "b3" || r.feature == "b4") r.feature = r.feature == "b3" ? "b4" : "b3";
  import(rows, true);
  const nlohmann::json swapped = check();
  ASSERT_EQ(swapped["questions"].size(), 1u);
  EXPECT_THAT(swapped["questions"][0]["question"].get<std::string>(),
              HasSubstr("'b3' as 'b4', 'b4' as 'b3'"));
}

/// What the simulated machines measure, with their errors, is never called a mistake.
TEST_F(Inputs, SimulatedSessionsRaiseNoQuestions) {
  for (const auto& [plan, machine] :
       {std::pair("nine_ball_plate", "three_axis"), std::pair("interferometer", "three_axis"),
        std::pair("five_axis_ball", "five_axis")}) {
    ASSERT_EQ(mmRun(folder_, std::string("simulate --machine ") + machine + " --plan config/plans/" + plan +
                                 ".yaml --hide random --seed 3 -o " + folder_ / "s.bag")
                  .status,
              0);
    const nlohmann::json set = check();
    EXPECT_TRUE(set["questions"].empty()) << plan << set["questions"].dump();
    EXPECT_TRUE(set["set_aside"].empty()) << plan << set["set_aside"].dump();
    EXPECT_TRUE(set["assumed"].empty()) << plan << set["assumed"].dump();
  }
}

/// An ISO 230-2 run of a real machine whose velocities were not written down: the same play.
TEST_F(Inputs, AnInterferometerRunNeedsNoVelocities) {
  MM_NEEDS_SHARED_DATA(data, "iso230_interferometer");
  std::istringstream lines(textOf(data / "x_axis.csv"));
  std::string bare;
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    bare += cells[0] + "," + cells[1] + "," + cells[3] + "\n";
  }
  const auto calibrated = [&](const std::string& csv) {
    EXPECT_EQ(
        mmRun(folder_, "import '" + csv + "' --machine three_axis --force -o " + folder_ / "x.bag").status,
        0);
    return calibrate("{type: position_table, axis: x}, {type: backlash, axis: x}", "x.bag").json();
  };
  const nlohmann::json known = calibrated(data / "x_axis.csv"),
                       assumed = calibrated(folder_.write("bare.csv", bare));
  EXPECT_EQ(assumed["parameters"], known["parameters"]);
  EXPECT_EQ(assumed["assumed"][0]["how"], "from the order of positions");
  EXPECT_EQ(assumed["repeatability_from"], "repeated");
  EXPECT_NEAR(assumed["repeatability_um"].get<double>(), 1.34, 0.01);
  EXPECT_NEAR(assumed["repeatability_relative_std"].get<double>(), 0.10, 0.01);
}

}  // namespace
}  // namespace mm
