#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tools/json_output.h"
#include "tools/one_line.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

TEST(JsonOutput, NeverHoldsNaNOrInfinity) {
  nlohmann::ordered_json value;
  value["rms_um"] = NAN;
  value["nested"] = {{"plain", INFINITY}, {"list", {1.0, -INFINITY}}};
  std::ostringstream out;
  printJson(out, value);
  EXPECT_EQ(out.str().find("nan"), std::string::npos);
  EXPECT_EQ(out.str().find("inf"), std::string::npos);
  const auto back = nlohmann::json::parse(out.str());
  EXPECT_TRUE(back["rms_um"].is_null());
  EXPECT_TRUE(back["nested"]["plain"].is_null());
  EXPECT_TRUE(back["nested"]["list"][1].is_null());
}

TEST(JsonOutput, NumbersReadBackToTheBit) {
  std::ostringstream out;
  printJson(out, {{"value", 0.1 + 0.2}});
  EXPECT_EQ(nlohmann::json::parse(out.str())["value"].get<double>(), 0.1 + 0.2);
}

TEST(JsonOutput, ForeignTextIsPrinted) {
  std::ostringstream out;
  printJson(out, {{"name", "b\xff"}});
  EXPECT_TRUE(nlohmann::json::accept(out.str()));
}

TEST(OneLine, BreaksAndRunsOfBlanksBecomeOneBlank) {
  EXPECT_EQ(oneLine("a\n  b\r\n\tc \n"), "a b c");
  EXPECT_EQ(oneLine("a\x1b[1m\n b"), "a\uFFFD[1m b");
  EXPECT_EQ(oneLine("\n"), "");
}

TEST(ProgressBar, IsSilentInAPipe) {
  testing::internal::CaptureStderr();  // a file, not a terminal
  {
    ProgressBar bar("reading");
    bar.show(0.5, "note");
    bar.callback()(1.0);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

}  // namespace
}  // namespace mm
