// What `mm` says and how it ends when the input is bad, or when the answer is no.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "axis_csv.h"
#include "run_mm.h"

namespace mm {
namespace {

/// An axis with a scale error, read at nine positions both ways, imported as s.bag.
class MmAnswers : public ::testing::Test {
 protected:
  void SetUp() override {
    const Answer imported = mmRun(folder_, "import " + folder_.write("s.csv", axisCsv(5)) +
                                               " --machine three_axis -o " + folder_ / "s.bag");
    ASSERT_EQ(imported.status, 0) << imported.error;
  }

  std::string model(const std::string& effects) const {
    return folder_.write("m.yaml", "machine: three_axis\neffects: [" + effects + "]\n");
  }
  Answer calibrate(const std::string& effects, const std::string& more = "") const {
    return mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + model(effects) + " -o " +
                              folder_ / "c.yaml" + " " + more);
  }
  /// Refused with status 2 and one line that holds every word.
  void expectRefused(const Answer& answer, const std::vector<std::string>& words) const {
    EXPECT_EQ(answer.status, 2);
    EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
    EXPECT_EQ(answer.error.rfind("mm: error: ", 0), 0u) << answer.error;
    for (const std::string& word : words)
      EXPECT_NE(answer.error.find(word), std::string::npos) << word << " in: " << answer.error;
  }

  TestFolder folder_;
};

TEST_F(MmAnswers, UnidentifiableModelInWords) {
  // the axis y was never moved: its scale has no influence
  const Answer answer = calibrate("{type: scale, axis: x}, {type: scale, axis: y}", "--json");
  EXPECT_EQ(answer.status, 1);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "c.yaml"));
  const nlohmann::json lost = answer.json()["identifiability"];
  EXPECT_EQ(lost["rank"], 1);
  EXPECT_EQ(lost["parameters"], 2);
  ASSERT_EQ(lost["lost"].size(), 1u);
  EXPECT_NE(lost["lost"][0]["in_words"].get<std::string>().find("axis: y"), std::string::npos);
  EXPECT_NE(answer.error.find("not determined"), std::string::npos) << answer.error;
}

TEST_F(MmAnswers, TwoParametersOfWhichOnlyTheSumCounts) {
  const Answer answer =
      calibrate("{type: scale, axis: x}, {type: formula, direction: x, formula: k1*x}", "--json");
  EXPECT_EQ(answer.status, 1);
  EXPECT_EQ(answer.json()["identifiability"]["rank"], 1);
}

TEST_F(MmAnswers, UnknownEffect) {
  expectRefused(calibrate("{type: backlahs, axis: x}"), {"backlahs", "backlash"});
}

TEST_F(MmAnswers, UnknownKeyOfAnEffect) {
  expectRefused(calibrate("{type: backlash, axes: x}"), {"axes", "axis"});
}

TEST_F(MmAnswers, UnknownAxis) { expectRefused(calibrate("{type: backlash, axis: w}"), {"'w'"}); }

TEST_F(MmAnswers, UnknownKeyOfTheModel) {
  const std::string file = folder_.write("m.yaml", "machine: three_axis\nefects: []\n");
  expectRefused(mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + file),
                {"m.yaml:2", "efects"});
}

TEST_F(MmAnswers, SensorThatIsNotThere) {
  expectRefused(calibrate("{type: thermal_growth, direction: x, sensor: spindle}"), {"spindle"});
}

TEST_F(MmAnswers, MachineOfAnotherSession) {
  const std::string file = folder_.write("m.yaml", "machine: five_axis\neffects: []\n");
  expectRefused(mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + file),
                {"five_axis", "joints"});
}

TEST_F(MmAnswers, UnknownMethod) {
  expectRefused(calibrate("{type: scale, axis: x}", "--method newton"), {"newton", "least_squares"});
}

TEST_F(MmAnswers, SettingsOutsideTheirBounds) {
  expectRefused(calibrate("{type: scale, axis: x}", "--father-share 2"), {"father"});
  expectRefused(calibrate("{type: scale, axis: x}", "--stages 15"), {"--stages", "15"});
  expectRefused(calibrate("{type: scale, axis: x}", "--repeatability-um -1"), {"repeatability"});
}

TEST_F(MmAnswers, FilesThatAreNotThere) {
  expectRefused(mmRun(folder_, "calibrate " + folder_ / "none.bag" + " --model " + model("")), {"none.bag"});
  expectRefused(mmRun(folder_, "calibrate " + folder_ / "s.bag" + " --model " + folder_ / "none.yaml"),
                {"none.yaml"});
  for (const std::string command : {"compare", "diagnose"})
    expectRefused(
        mmRun(folder_, command + " " + folder_ / "s.bag" + " --calibration " + folder_ / "none.yaml"),
        {"none.yaml"});
  for (const std::string command : {"add", "remove"})
    expectRefused(mmRun(folder_, command + " " + folder_ / "s.bag" +
                                     " '{type: backlash, axis: x}' --calibration " + folder_ / "none.yaml"),
                  {"none.yaml"});
  expectRefused(mmRun(folder_, "check " + folder_ / "none.bag"), {"none.bag"});
  expectRefused(calibrate("{type: scale, axis: x}", "--curve " + folder_ / "no/curve.csv"), {"no"});
}

TEST_F(MmAnswers, DamagedCalibration) {
  ASSERT_EQ(calibrate("{type: scale, axis: x}").status, 0);
  std::string text = textOf(folder_ / "c.yaml");
  const std::size_t at = text.find("value_si: ");
  ASSERT_NE(at, std::string::npos);
  text[at + 10] = text[at + 10] == '1' ? '2' : '1';
  folder_.write("c.yaml", text);
  for (const std::string command : {"compare", "diagnose"})
    expectRefused(mmRun(folder_, command + " " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml"),
                  {"c.yaml"});
}

TEST_F(MmAnswers, TooFewRows) {
  const std::string csv = folder_.write("few.csv", "time_s,x_mm,deviation_x_um\n0,1,3\n1,2,4\n");
  ASSERT_EQ(mmRun(folder_, "import " + csv + " --machine three_axis -o " + folder_ / "few.bag").status, 0);
  const Answer answer =
      mmRun(folder_, "calibrate " + folder_ / "few.bag" + " --model " +
                         model("{type: scale, axis: x}, {type: positioning_polynomial, axis: x, degree: 2}, "
                               "{type: positioning_polynomial, axis: x, degree: 3}") +
                         " -o " + folder_ / "few.yaml");
  EXPECT_EQ(answer.status, 1);
  EXPECT_FALSE(answer.error.empty());
}

TEST_F(MmAnswers, NothingButJsonOnStandardOutput) {
  const Answer answer = calibrate("{type: scale, axis: x}", "--json");
  ASSERT_EQ(answer.status, 0) << answer.error;
  const nlohmann::json result = answer.json();
  for (const char* key : {"observations", "rms_um", "held_out_rms_um", "chi2_per_dof", "converged", "genetic",
                          "polish", "parameters", "identifiability", "artifact", "outliers"})
    EXPECT_TRUE(result.contains(key)) << key;
  EXPECT_EQ(result["observations"], 54);
  EXPECT_EQ(result["parameters"][0]["effect"], (nlohmann::json{{"type", "scale"}, {"axis", "x"}}));
  EXPECT_NEAR(result["parameters"][0]["value"].get<double>(), 400.0, 5.0);  // 0.4 um a mm
  EXPECT_NEAR(result["rms_um"].get<double>(), 1.0 / std::sqrt(12.0), 0.06);
  EXPECT_TRUE(answer.error.empty()) << answer.error;
}

TEST_F(MmAnswers, OneSeedOneResultWhateverTheThreads) {
  Answer one = calibrate("{type: scale, axis: x}, {type: backlash, axis: x}", "--json --seed 7 --threads 1");
  Answer two = calibrate("{type: scale, axis: x}, {type: backlash, axis: x}", "--json --seed 7 --threads 2");
  nlohmann::json a = one.json(), b = two.json();
  a["genetic"].erase("seconds");
  b["genetic"].erase("seconds");
  EXPECT_EQ(a.dump(), b.dump());
}

TEST_F(MmAnswers, CurveOfTheGeneticAlgorithm) {
  ASSERT_EQ(
      calibrate("{type: scale, axis: x}", "--generations 12 --population 40 --curve " + folder_ / "curve.csv")
          .status,
      0);
  const std::string curve = textOf(folder_ / "curve.csv");
  EXPECT_EQ(curve.rfind("generation,rms_um\n0,", 0), 0u);
  EXPECT_EQ(std::count(curve.begin(), curve.end(), '\n'), 14);
}

TEST_F(MmAnswers, TheMethodThatWasAskedFor) {
  for (const std::string method : {"staged_mutation", "niching"}) {
    const nlohmann::json result = calibrate("{type: scale, axis: x}", "--json --method " + method).json();
    EXPECT_EQ(result["genetic"]["method"], method);
    EXPECT_EQ(result["genetic"]["generations"], method == "niching" ? 500 : 100);
    EXPECT_NEAR(result["parameters"][0]["value"].get<double>(), 400.0, 5.0);
  }
  EXPECT_TRUE(
      calibrate("{type: scale, axis: x}", "--json --method least_squares").json()["genetic"].is_null());
}

TEST_F(MmAnswers, InterruptedButNotLost) {
  const std::string file = model("{type: scale, axis: x}, {type: backlash, axis: x}");
  const Answer answer = stoppedWhen(
      workedFor(1.5), folder_,
      "calibrate s.bag --model '" + file + "' -o c.yaml --generations 10000000 --stages 10000000:1");
  EXPECT_EQ(answer.status, 130) << answer.error;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "c.yaml"));
  EXPECT_NE(answer.error.find("best result so far"), std::string::npos) << answer.error;
}

TEST_F(MmAnswers, WhatAddDidRemoveTakesBack) {
  ASSERT_EQ(calibrate("{type: scale, axis: x}").status, 0);
  const std::string bag = folder_ / "s.bag", effect = " '{type: backlash, axis: x}' ";
  const Answer added = mmRun(folder_, "add " + bag + effect + "--calibration " + folder_ / "c.yaml" + " -o " +
                                          folder_ / "c2.yaml" + " --json");
  ASSERT_EQ(added.status, 0) << added.error;
  const Answer removed = mmRun(folder_, "remove " + bag + effect + "--calibration " + folder_ / "c2.yaml" +
                                            " -o " + folder_ / "c3.yaml" + " --json");
  ASSERT_EQ(removed.status, 0) << removed.error;
  const nlohmann::json ledger = removed.json()["ledger"];
  ASSERT_EQ(ledger.size(), 3u);
  EXPECT_EQ(ledger[1]["action"], "add");
  EXPECT_EQ(ledger[1]["effect"]["type"], "backlash");
  EXPECT_EQ(ledger[2]["action"], "remove");
  for (const char* figure : {"rms_um", "held_out_rms_um"}) {
    EXPECT_NEAR(ledger[2][figure][1].get<double>(), ledger[0][figure][1].get<double>(), 1e-9) << figure;
    EXPECT_NEAR(ledger[1][figure][0].get<double>(), ledger[0][figure][1].get<double>(), 1e-9) << figure;
  }
  EXPECT_FALSE(ledger[2]["calibration"].get<std::string>().empty());
  expectRefused(mmRun(folder_, "add " + bag + effect + "--calibration " + folder_ / "c2.yaml"),
                {"already", "scale"});
  expectRefused(mmRun(folder_, "remove " + bag + effect + "--calibration " + folder_ / "c.yaml"),
                {"not in the model", "scale"});
}

TEST_F(MmAnswers, CompareHoldsTheValues) {
  ASSERT_EQ(calibrate("{type: scale, axis: x}").status, 0);
  const Answer same =
      mmRun(folder_, "compare " + folder_ / "s.bag" + " --calibration " + folder_ / "c.yaml" + " --json");
  ASSERT_EQ(same.status, 0) << same.error;
  EXPECT_NEAR(same.json()["rms_um"].get<double>(), 1.0 / std::sqrt(12.0), 0.06);
  for (const char* key : {"observations", "repeatability_um", "repeatability_from", "rms_um", "max_um",
                          "quantiles_um", "chi2_per_dof", "held_out_rms_um", "where", "outliers"})
    EXPECT_TRUE(same.json().contains(key)) << key;

  // the same machine a day later, its scale 100 um/m longer: 0.1 um a mm over 20 mm, RMS 1.29 um
  std::string later = "time_s,x_mm,deviation_x_um\n";
  for (int i = 0; i < 9; ++i)
    later += std::to_string(i) + "," + std::to_string(-20 + 5 * i) + "," +
             std::to_string(0.5 * (-20 + 5 * i)) + "\n";
  ASSERT_EQ(mmRun(folder_, "import " + folder_.write("later.csv", later) + " --machine three_axis -o " +
                               folder_ / "later.bag")
                .status,
            0);
  const Answer other =
      mmRun(folder_, "compare " + folder_ / "later.bag" + " --calibration " + folder_ / "c.yaml" + " --json");
  ASSERT_EQ(other.status, 0) << other.error;
  EXPECT_NEAR(other.json()["rms_um"].get<double>(), 1.29, 0.1);
}

TEST_F(MmAnswers, CheckTellsWhatWasCovered) {
  const Answer answer =
      mmRun(folder_, "check " + folder_ / "s.bag" + " --model " +
                         model("{type: scale, axis: x}, {type: scale, axis: y}") + " --json");
  EXPECT_EQ(answer.status, 1);
  const nlohmann::json set = answer.json();
  EXPECT_EQ(set["references"], 54);
  EXPECT_EQ(set["joints"][0]["positions"], 9);
  EXPECT_EQ(set["joints"][0]["travel"]["up"], 27);
  EXPECT_EQ(set["joints"][0]["travel"]["down"], 27);
  EXPECT_EQ(set["identifiability"]["rank"], 1);
  bool yBacklash = false, xBacklash = false;
  for (const auto& c : set["cannot_show"])
    if (c["effect"]["type"] == "backlash")
      (c["effect"]["axis"] == "y" ? yBacklash : xBacklash) |= c["effect"]["axis"] != "z";
  EXPECT_TRUE(yBacklash);
  EXPECT_FALSE(xBacklash);
  EXPECT_EQ(mmRun(folder_, "check " + folder_ / "s.bag").status, 0);
}

}  // namespace
}  // namespace mm
