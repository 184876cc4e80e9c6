#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "axis_csv.h"
#include "run_mm.h"

namespace mm {

/// A folder with what the commands of `mm` read: an axis with a scale error as CSV (s.csv), bag (s.bag),
/// model (m.yaml) and calibration (c.yaml); a later session of it (t.bag, with t.yaml); a machine with other
/// joints (five.bag); a plan and an artifact. Made once, for all tests that only look whether it stays as it
/// is.
class SessionFolder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TestFolder;
    const TestFolder& f = *folder_;
    f.write("s.csv", axisCsv(5));
    f.write("t.csv", axisCsv(6));
    f.write("m.yaml", "machine: three_axis\neffects: [{type: scale, axis: x}]\n");
    f.write("plan.yaml", textOf("config/plans/nine_ball_plate.yaml"));
    f.write(
        "artifact.yaml",
        "name: one\npose: known\nprobe: {tip_radius_mm: 1.0}\nballs:\n  - {name: b0, centre_mm: [0, 0, 0], "
        "radius_mm: 4}\n");
    f.write("states.csv", "time_s,x_mm,y_mm,z_mm,x_velocity_mm_s\n0,1,2,3,1\n1,2,3,4,1\n");
    f.write("series.csv", series());
    run("import s.csv --machine three_axis -o s.bag");
    run("import t.csv --machine three_axis -o t.bag");
    run("calibrate s.bag --model m.yaml --method least_squares -o c.yaml");
    run("calibrate t.bag --model m.yaml --method least_squares -o t.yaml");
    run("simulate --machine five_axis --plan " +
        std::filesystem::absolute("config/plans/five_axis_ball.yaml").string() + " -o five.bag");
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string series() {
    std::string csv = "time_s,bed,frame,nose_um\n";
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0.0, 0.1);
    for (int i = 0; i < 200; ++i) {
      const double bed = 20.0 + std::sin(0.1 * i), frame = 21.0 + std::cos(0.07 * i);
      csv += std::to_string(i) + "," + std::to_string(bed + 0.1 * noise(random)) + "," +
             std::to_string(frame) + "," + std::to_string(5.0 * (bed - 20.0) + noise(random)) + "\n";
    }
    return csv;
  }

  /// Typed inside the folder.
  static Answer typed(const std::string& arguments) {
    const std::string out = *folder_ / "stdout.txt", error = *folder_ / "stderr.txt";
    const int status = std::system(("cd '" + *folder_ / "." + "' && " + programAnd(arguments) + " >'" + out +
                                    "' 2>'" + error + "' </dev/null")
                                       .c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, textOf(out), textOf(error)};
  }
  static void run(const std::string& arguments) {
    const Answer answer = typed(arguments);
    ASSERT_EQ(answer.status, 0) << arguments << ": " << answer.error;
  }

  /// Every file of the folder but what `mm` printed.
  static std::map<std::string, std::string> files() {
    std::map<std::string, std::string> all;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(*folder_ / ".")) {
      const std::string name = entry.path().filename().string();
      if (entry.is_regular_file() && name != "stdout.txt" && name != "stderr.txt")
        all[entry.path().string()] = textOf(entry.path().string());
    }
    return all;
  }

  /// Status 2, one line that holds every word, nothing else, and every file as it was.
  static void expectRefused(const std::string& arguments, const std::vector<std::string>& words) {
    SCOPED_TRACE("mm " + arguments);
    const auto before = files();
    const Answer answer = typed(arguments);
    EXPECT_EQ(answer.status, 2) << answer.error << answer.out;
    EXPECT_EQ(std::count(answer.error.begin(), answer.error.end(), '\n'), 1) << answer.error;
    const std::string name = arguments.rfind("mm-benchmark", 0) == 0 ? "mm-benchmark" : "mm";
    EXPECT_EQ(answer.error.rfind(name + ": error: ", 0), 0u) << answer.error;
    // of a file that it refuses an import shows what it understood
    if (arguments.rfind("import ", 0) != 0) {
      EXPECT_EQ(answer.out, "");
    }
    for (const std::string& word : words)
      EXPECT_NE(answer.error.find(word), std::string::npos) << word << " in: " << answer.error;
    const auto after = files();
    for (const auto& [name, text] : before)
      EXPECT_TRUE(after.count(name) > 0 && after.at(name) == text) << name << " was changed";
    for (const auto& [name, text] : after) EXPECT_GT(before.count(name), 0u) << name << " was left behind";
  }

  static inline TestFolder* folder_ = nullptr;
};

}  // namespace mm
