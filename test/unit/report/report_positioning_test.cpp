#include <gtest/gtest.h>

#include <cmath>

#include "report/iso_tests.h"

namespace mm {
namespace {

// Worked by hand from the definitions of ISO 230-2:2014. Three targets, three runs each way, um:
//
//   target      forward       mean  s   4s  mean+2s mean-2s |  backward      mean  s   4s  mean+2s mean-2s
//     0 mm     1   3   2       2    1   4      4       0     |  -1  -2   0    -1    1   4      1      -3
//    10 mm     5   9   7       7    2   8     11       3     |   1   2   3     2    1   4      4       0
//    20 mm     4   5   6       5    1   4      7       3     |   4  10   7     7    3  12     13       1
//
//   A forward  = 11 - 0 = 11     A backward = 13 - (-3) = 16     A = 13 - (-3) = 16
//   E forward  = 7 - 2 = 5       E backward = 7 - (-1) = 8       E = 7 - (-1) = 8
//   R forward  = 8               R backward = 12
//   reversal B_i = forward - backward: 3, 5, -2; B = 5, mean B = 6 / 3 = 2
//   mean bi-directional deviations 0.5, 4.5, 6; M = 5.5
//   R_i = max(2 s + 2 s + |B_i|, 4 s, 4 s): 2 + 2 + 3 = 7, 4 + 2 + 5 = 11, max(2 + 6 + 2, 4, 12) = 12; R = 12
TEST(ReportPositioning, FiguresOfTheStandardWorkedByHand) {
  const std::vector<std::vector<double>> forward = {{1, 3, 2}, {5, 9, 7}, {4, 5, 6}},
                                         backward = {{-1, -2, 0}, {1, 2, 3}, {4, 10, 7}};
  std::vector<PositioningRun> runs;
  for (int run = 0; run < 3; ++run)  // as measured: up and down, run after run
    for (const bool up : {true, false})
      for (int k = 0; k < 3; ++k) {
        const int target = up ? k : 2 - k;
        runs.push_back({10.0 * target, (up ? forward : backward)[target][run], up});
      }
  const PositioningTest test = positioningTest(runs);
  ASSERT_EQ(test.targets.size(), 3u);
  EXPECT_DOUBLE_EQ(test.targets[1].at, 10.0);
  EXPECT_EQ(test.targets[1].forward, 3);
  EXPECT_DOUBLE_EQ(test.targets[1].meanForward, 7.0);
  EXPECT_DOUBLE_EQ(test.targets[1].sForward, 2.0);
  EXPECT_DOUBLE_EQ(test.targets[2].meanBackward, 7.0);
  EXPECT_DOUBLE_EQ(test.targets[2].sBackward, 3.0);
  const PositioningFigures& f = test.figures;
  EXPECT_DOUBLE_EQ(f.forward.accuracy, 11.0);
  EXPECT_DOUBLE_EQ(f.backward.accuracy, 16.0);
  EXPECT_DOUBLE_EQ(f.accuracy, 16.0);
  EXPECT_DOUBLE_EQ(f.forward.systematic, 5.0);
  EXPECT_DOUBLE_EQ(f.backward.systematic, 8.0);
  EXPECT_DOUBLE_EQ(f.systematic, 8.0);
  EXPECT_DOUBLE_EQ(f.forward.repeatability, 8.0);
  EXPECT_DOUBLE_EQ(f.backward.repeatability, 12.0);
  EXPECT_DOUBLE_EQ(f.repeatability, 12.0);
  EXPECT_DOUBLE_EQ(f.reversal, 5.0);
  EXPECT_DOUBLE_EQ(f.meanReversal, 2.0);
  EXPECT_DOUBLE_EQ(f.meanRange, 5.5);
  // variances: s^2 / 3 of a mean, s^2 / 4 of a standard deviation
  const auto expectVariance = [](double std, double variance) { EXPECT_NEAR(std * std, variance, 1e-6); };
  expectVariance(test.std.forward.accuracy, (4.0 / 3.0 + 4.0) + (1.0 / 3.0 + 1.0));
  expectVariance(test.std.backward.accuracy, (3.0 + 9.0) + (1.0 / 3.0 + 1.0));
  expectVariance(test.std.accuracy, (3.0 + 9.0) + (1.0 / 3.0 + 1.0));
  expectVariance(test.std.forward.systematic, 4.0 / 3.0 + 1.0 / 3.0);
  expectVariance(test.std.backward.systematic, 3.0 + 1.0 / 3.0);
  expectVariance(test.std.forward.repeatability, 16.0);
  expectVariance(test.std.backward.repeatability, 36.0);
  expectVariance(test.std.repeatability, 36.0);
  expectVariance(test.std.reversal, 4.0 / 3.0 + 1.0 / 3.0);
  expectVariance(test.std.meanReversal, (17.0 / 3.0) / 9.0);
  expectVariance(test.std.meanRange, 0.25 * (1.0 / 3.0 + 3.0) + 0.25 * (2.0 / 3.0));
}

TEST(ReportPositioning, TheReversalErrorIsAnAmountItsMeanHasASign) {
  const PositioningTest test = positioningTest({{0, -3, true}, {0, 1, false}, {5, -2, true}, {5, 0, false}});
  EXPECT_DOUBLE_EQ(test.figures.reversal, 4.0);
  EXPECT_DOUBLE_EQ(test.figures.meanReversal, -3.0);
}

TEST(ReportPositioning, ASingleRunHasNoRepeatability) {
  const PositioningTest test = positioningTest({{0, 1, true}, {0, -1, false}, {5, 2, true}, {5, 0, false}});
  EXPECT_DOUBLE_EQ(test.figures.systematic, 3.0);
  EXPECT_DOUBLE_EQ(test.figures.reversal, 2.0);
  EXPECT_TRUE(std::isnan(test.figures.accuracy));
  EXPECT_TRUE(std::isnan(test.figures.repeatability));
  EXPECT_TRUE(std::isnan(test.figures.forward.accuracy));
  EXPECT_DOUBLE_EQ(test.figures.forward.systematic, 1.0);
  EXPECT_TRUE(std::isnan(test.std.systematic));
}

TEST(ReportPositioning, ATargetIsReachedUpToItsDeviation) {
  EXPECT_EQ(
      positioningTest({{0.0, 1, true}, {0.01, 2, true}, {10.0, 3, true}, {9.995, 4, false}}).targets.size(),
      2u);
}

}  // namespace
}  // namespace mm
