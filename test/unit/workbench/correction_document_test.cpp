// The correction that the page draws, against a scale computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compensation_support.h"
#include "workbench/calibration_documents.h"

namespace mm {
namespace {

TEST(CorrectionDocument, IsTheFieldOverTheCalibratedVolume) {
  constexpr double kScale = 100e-6;
  Calibration c = test::calibrationOf(Machine::load("three_axis"), {EffectSpec("scale").set("axis", "x")});
  c.values[0].value = kScale;
  const auto field = nlohmann::json::parse(correctionDocument(&c, nullptr))["active"];
  const auto &at = field["at_mm"], &move = field["move_um"];
  ASSERT_GT(at.size(), 8U);
  ASSERT_EQ(at.size(), move.size());
  double lowest = 0.0, highest = 0.0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double x = at[i][0];
    lowest = std::min(lowest, x);
    highest = std::max(highest, x);
    EXPECT_NEAR(move[i][0].get<double>(), 1e3 * kScale * x, 0.01) << x;  // um of mm
    EXPECT_NEAR(move[i][1].get<double>(), 0.0, 0.01);
  }
  EXPECT_NEAR(lowest, -20.0, 0.01);  // of calibrationOf
  EXPECT_NEAR(highest, 20.0, 0.01);
}

}  // namespace
}  // namespace mm
