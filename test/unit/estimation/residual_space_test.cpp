#include "estimation/residual_space.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

TEST(LogPValueF, MatchesTablesAndStaysFiniteFarOut) {
  // upper 5 % and 1 % points of the F distribution (published tables)
  EXPECT_NEAR(std::exp(logPValueF(4.9646, 1, 10)), 0.05, 1e-5);
  EXPECT_NEAR(std::exp(logPValueF(5.6363, 5, 10)), 0.01, 1e-5);
  EXPECT_NEAR(std::exp(logPValueF(1.0, 10, 10)), 0.5, 1e-12);
  EXPECT_LT(logPValueF(1e6, 2, 600), -600.0);
  EXPECT_TRUE(std::isfinite(logPValueF(1e12, 2, 600)));
  EXPECT_EQ(logPValueF(0.0, 2, 600), 0.0);
}

}  // namespace
}  // namespace mm
