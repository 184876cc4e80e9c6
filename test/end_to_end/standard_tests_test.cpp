// The tests of the standards as typed: a table of readings, what mm check calls it, and its page.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "run_mm.h"

namespace mm {
namespace {

/// A spindle that turns from 0 to 2 h and stands to 3 h, every five minutes: Z grows by 6 um/h, then stays;
/// every other reading is 0.1 um too large.
std::string spindleTable() {
  std::string table =
      "time_s,x_mm,y_mm,z_mm,reference_x_mm,reference_y_mm,reference_z_mm,spindle_rpm,nose_degC\n";
  for (int i = 0; i <= 36; ++i) {
    const double hour = i / 12.0, heated = std::min(hour, 2.0);
    char line[200];
    const double odd = i % 2 == 0 ? 0.0 : 1e-4;
    std::snprintf(line, sizeof line, "%d,0,0,0,%.6f,%.6f,%.6f,%d,%.3f\n", 300 * i, odd, odd,
                  6e-3 * heated + odd, i > 0 && hour <= 2.0 ? 8000 : 0, 20.0 + 3.0 * heated);
    table += line;
  }
  return table;
}

/// The JSON that a page holds.
nlohmann::json dataOf(const std::string& page) {
  const std::string mark = "<script type=\"application/json\" id=\"data\">";
  const std::size_t from = page.find(mark) + mark.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from));
}

TEST(StandardTestsAsTyped, ASpindleIsRecognisedAndItsPageNeedsNoCalibration) {
  TestFolder folder;
  const std::string table = folder.write("spindle.csv", spindleTable()), bag = folder / "s.bag";
  ASSERT_EQ(mmRun(folder, "import " + table + " --machine three_axis -o " + bag).status, 0);
  const Answer check = mmRun(folder, "check " + bag + " --json");
  ASSERT_EQ(check.json()["tests"].size(), 1u) << check.out;
  EXPECT_EQ(check.json()["tests"][0]["in_words"],
            "ISO 230-3, spindle turning for 2.0 h: 37 readings at one position over 3.0 h");
  const std::string plotly = folder.write("plotly.min.js", "/* plotly */" + std::string(200000, ' '));
  const Answer report = mmRun(folder, "report " + bag + " --plotly " + plotly + " -o " + folder / "p.html");
  ASSERT_EQ(report.status, 0) << report.error;
  const nlohmann::json data = dataOf(textOf(folder / "p.html"));
  EXPECT_TRUE(data["calibration"].is_null());
  const nlohmann::json& test = data["thermal"]["tests"][0];
  EXPECT_EQ(test["test"], "iso230-3");
  EXPECT_EQ(test["kind"], "spindle");
  const nlohmann::json& z = test["courses"][2]["measured_figures"];
  EXPECT_NEAR(z["first_hour"]["value"].get<double>(), 6.0, 1e-3);
  EXPECT_NEAR(z["heated"]["value"].get<double>(), 12.0, 1e-3);
  EXPECT_NEAR(z["recovery"]["value"].get<double>(), 0.0, 1e-3);
  EXPECT_NEAR(data["thermal"]["temperatures"][0]["range"].get<double>(), 6.0, 1e-3);
}

}  // namespace
}  // namespace mm
