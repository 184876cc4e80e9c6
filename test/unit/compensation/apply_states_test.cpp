#include "compensation/apply_states.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

#include "base/error.h"
#include "compensation_support.h"

namespace mm {
namespace {

using test::calibrationOf;

class ApplyStates : public testing::Test {
 protected:
  ~ApplyStates() override { std::filesystem::remove(file_); }

  /// Rows of the output: the cells behind the original text.
  std::vector<std::vector<std::string>> apply(const Calibration& c, const std::string& csv) {
    std::ofstream(file_) << csv;
    out_.clear();
    applied_ = applyStates(file_, c, Compensator(c), out_);
    std::istringstream lines(out_), original(csv);
    std::vector<std::vector<std::string>> rows;
    std::string line, before;
    while (std::getline(lines, line)) {
      std::getline(original, before);
      EXPECT_EQ(line.compare(0, before.size() + 1, before + ","), 0) << line;
      std::istringstream cells(line.substr(before.size() + 1));
      rows.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }

  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("mm_states_" + std::to_string(::getpid()) + ".csv");
  std::string out_;
  AppliedStates applied_;
};

TEST_F(ApplyStates, addsItsColumnsBehindTheTextOfEachRow) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  c.values[0].value = 1e-3;
  const auto rows = apply(c,
                          "time_s,x_mm, y_mm ,operator_id\n"
                          "5,10.0,1e0,7\n"
                          "4, -5 ,\"2\",8\n"
                          "6,90,3,9\n");
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"corrected_x_mm", "corrected_y_mm", "corrected_z_mm",
                                               "sigma_um", "valid"}));
  EXPECT_EQ(rows[1][0], "10.010000000");
  EXPECT_EQ(rows[1][1], "1.000000000");
  EXPECT_EQ(rows[1][4], "1");
  EXPECT_NEAR(std::stod(rows[1][3]), 1e-8 * 10e-3 / std::sqrt(3.0) * 1e6, 1e-10);
  EXPECT_EQ(rows[2][0], "-5.005000000");
  EXPECT_EQ(rows[2][4], "1");
  EXPECT_EQ(rows[3][4], "0");  // outside, but said where it would be
  EXPECT_EQ(rows[3][0], "90.090000000");
  EXPECT_EQ(applied_.rows, 3u);
  EXPECT_EQ(applied_.valid, 2u);
  EXPECT_NE(applied_.firstReason.find("line 4: x = 90 mm"), std::string::npos) << applied_.firstReason;
}

TEST_F(ApplyStates, remembersTheTravelAndLeavesEmptyWhatIsNotKnown) {
  Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("backlash").set("axis", "x")});
  c.values[0].value = 4e-6;
  const auto rows = apply(c,
                          "time_s,x_mm,x_velocity_mm_s\n"
                          "0,1,0\n"
                          "1,1,-2\n"
                          "2,1,0\n"
                          "3,1,2\n");
  EXPECT_EQ(rows[1][0], "");
  EXPECT_EQ(rows[1][4], "0");
  EXPECT_EQ(rows[2][0], "1.002000000");
  EXPECT_EQ(rows[3][0], "1.002000000");
  EXPECT_EQ(rows[4][0], "0.998000000");
}

TEST_F(ApplyStates, takesTheTemperatureOfTheRowItself) {
  Calibration c = calibrationOf(Machine::load("three_axis"),
                                {EffectSpec("thermal_growth").set("direction", "z").set("sensor", "bed")});
  c.values[0].value = 1e-6;
  const auto rows = apply(c, "time_s,bed_degC\n0,21\n0,24\n10,\n20,22\n");
  EXPECT_EQ(rows[1][2], "0.001000000");
  EXPECT_EQ(rows[2][2], "0.004000000");
  EXPECT_EQ(rows[3][2], "0.003000000");  // between its neighbours
  EXPECT_EQ(rows[4][2], "0.002000000");
  const auto none = apply(c, "time_s,x_mm\n0,1\n");
  EXPECT_EQ(none[1][4], "0");
  EXPECT_NE(applied_.firstReason.find("bed"), std::string::npos);
}

TEST_F(ApplyStates, countsTimeOnTheClockOfTheSession) {
  Calibration c = calibrationOf(Machine::load("three_axis"),
                                {EffectSpec("formula").set("direction", "x").set("formula", "k1*t")});
  c.values[0].value = 1.0;
  c.sessionEpoch = 1000000000.0 + 50.0;  // imported from a CSV whose first time_s was 50
  auto rows = apply(c, "time_s,x_mm\n60,0\n70,0\n");
  const double ten = std::stod(rows[1][0]), twenty = std::stod(rows[2][0]);
  EXPECT_GT(std::abs(ten), 0.0);
  EXPECT_NEAR(twenty / ten, 2.0, 1e-6);
  rows = apply(c, "time_s,x_mm\n5000,1\n");
  EXPECT_EQ(rows[1][0], "1.000000000");
  EXPECT_EQ(applied_.untimed, 1u);
  EXPECT_NE(applied_.firstNote.find("not applied"), std::string::npos);
  rows = apply(c, "x_mm\n1\n");  // no time: not guessed
  EXPECT_EQ(rows[1][4], "0");
}

TEST_F(ApplyStates, refusesColumnsThatItDoesNotKnow) {
  const Calibration c = calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  EXPECT_THROW(apply(c, "time_s,x_inch\n0,1\n"), InputError);
  EXPECT_THROW(apply(c, "time_s,x_mm\n0,one\n"), InputError);
}

}  // namespace
}  // namespace mm
