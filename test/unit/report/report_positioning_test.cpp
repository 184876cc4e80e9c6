#include "report/report_positioning.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

// Three targets, two runs each way; figures worked out by hand from the formulas of ISO 230-2:2014.
TEST(ReportPositioning, FiguresOfTheStandard) {
  const PositioningTest test = positioningTest({{0, 1, true},
                                                {0, 3, true},
                                                {0, -1, false},
                                                {0, -1, false},
                                                {10, 5, true},
                                                {10, 5, true},
                                                {10, 1, false},
                                                {10, 3, false},
                                                {20, 4, true},
                                                {20, 6, true},
                                                {20, 4, false},
                                                {20, 4, false}});
  ASSERT_EQ(test.targets.size(), 3u);
  EXPECT_DOUBLE_EQ(test.targets[0].meanForward, 2.0);
  EXPECT_DOUBLE_EQ(test.targets[0].meanBackward, -1.0);
  EXPECT_DOUBLE_EQ(test.targets[0].sForward, std::sqrt(2.0));
  EXPECT_DOUBLE_EQ(test.targets[0].sBackward, 0.0);
  const PositioningFigures& f = test.figures;
  EXPECT_DOUBLE_EQ(f.systematic, 6.0);          // 5 - (-1)
  EXPECT_DOUBLE_EQ(f.meanRange, 4.0);           // 4.5 - 0.5
  EXPECT_DOUBLE_EQ(f.reversal, 3.0);            // at 0 and at 10
  EXPECT_DOUBLE_EQ(f.meanReversal, 7.0 / 3.0);  // (3 + 3 + 1) / 3
  EXPECT_NEAR(f.accuracy, 5.0 + 2.0 * std::sqrt(2.0) + 1.0, 1e-12);
  EXPECT_NEAR(f.repeatabilityForward, 4.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(f.repeatabilityBackward, 4.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(f.repeatability, 2.0 * std::sqrt(2.0) + 3.0, 1e-12);
}

TEST(ReportPositioning, ASingleRunHasNoRepeatability) {
  const PositioningTest test = positioningTest({{0, 1, true}, {0, -1, false}, {5, 2, true}, {5, 0, false}});
  EXPECT_DOUBLE_EQ(test.figures.systematic, 3.0);
  EXPECT_DOUBLE_EQ(test.figures.reversal, 2.0);
  EXPECT_TRUE(std::isnan(test.figures.accuracy));
  EXPECT_TRUE(std::isnan(test.figures.repeatability));
}

TEST(ReportPositioning, ATargetIsReachedUpToItsDeviation) {
  EXPECT_EQ(
      positioningTest({{0.0, 1, true}, {0.01, 2, true}, {10.0, 3, true}, {9.995, 4, false}}).targets.size(),
      2u);
}

}  // namespace
}  // namespace mm
