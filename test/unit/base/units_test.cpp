#include "base/units.h"

#include <gtest/gtest.h>

namespace mm {
namespace {

TEST(Units, convertToSi) {
  EXPECT_DOUBLE_EQ(180.0 * kDegree, kPi);
  EXPECT_DOUBLE_EQ(3600.0 * kArcsecond, kDegree);
  EXPECT_DOUBLE_EQ(1000.0 * kMicrometre, kMillimetre);
}

}  // namespace
}  // namespace mm
