#include <gtest/gtest.h>

#include <cmath>

#include "base/json_text.h"
#include "tools/one_line.h"
#include "tools/progress_bar.h"

namespace mm {
namespace {

TEST(JsonText, NeverHoldsNaNOrInfinity) {
  nlohmann::ordered_json value;
  value["rms_um"] = NAN;
  value["nested"] = {{"plain", INFINITY}, {"list", {1.0, -INFINITY}}};
  const std::string text = jsonText(value);
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
  const auto back = nlohmann::json::parse(text);
  EXPECT_TRUE(back["rms_um"].is_null());
  EXPECT_TRUE(back["nested"]["plain"].is_null());
  EXPECT_TRUE(back["nested"]["list"][1].is_null());
}

TEST(JsonText, NumbersReadBackToTheBit) {
  EXPECT_EQ(nlohmann::json::parse(jsonText({{"value", 0.1 + 0.2}}))["value"].get<double>(), 0.1 + 0.2);
}

TEST(JsonText, ForeignTextIsPrinted) { EXPECT_TRUE(nlohmann::json::accept(jsonText({{"name", "b\xff"}}))); }

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
