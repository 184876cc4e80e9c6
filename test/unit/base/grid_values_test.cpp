#include "base/grid_values.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(GridValues, APlaceIsBetweenItsNeighboursOrAtTheEnd) {
  const std::vector<double> at = {0.0, 1.0, 4.0};
  EXPECT_EQ(placeAmong(at, 2.5), std::make_pair(std::size_t{1}, 0.5));
  EXPECT_EQ(placeAmong(at, 1.0), std::make_pair(std::size_t{1}, 0.0));
  EXPECT_EQ(placeAmong(at, -3.0), std::make_pair(std::size_t{0}, 0.0));
  EXPECT_EQ(placeAmong(at, 9.0), std::make_pair(std::size_t{1}, 1.0));
}

TEST(GridValues, AreLinearAlongEachAxisAndHoldTheBorder) {
  const std::vector<std::vector<double>> at = {{0.0, 10.0}, {0.0, 1.0, 3.0}};
  const std::vector<double> values = {0.0, 1.0, 2.0, 100.0, 101.0, 302.0};  // the second axis is the fastest
  const auto value = [&](double a, double b) { return gridValue(gridCorners(at, {a, b}), values); };
  EXPECT_DOUBLE_EQ(value(0.0, 2.0), 1.5);
  EXPECT_DOUBLE_EQ(value(5.0, 0.0), 50.0);
  EXPECT_DOUBLE_EQ(value(5.0, 2.0), 0.25 * (1.0 + 2.0 + 101.0 + 302.0));
  EXPECT_DOUBLE_EQ(value(99.0, 99.0), 302.0);
  EXPECT_DOUBLE_EQ(value(-1.0, -1.0), 0.0);
}

}  // namespace
}  // namespace mm
