#include "base/distributions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace mm {
namespace {

// Values of printed tables (NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7).
TEST(Distributions, AreThoseOfTheTables) {
  EXPECT_NEAR(normalBelow(1.959964), 0.975, 1e-7);
  EXPECT_NEAR(normalQuantile(0.975), 1.959964, 1e-6);
  EXPECT_NEAR(studentTail(2.228, 10), 0.025, 1e-5);
  EXPECT_NEAR(studentLimit(0.025, 10), 2.228, 5e-4);
  EXPECT_NEAR(fisherTail(2.978, 10, 10), 0.05, 1e-4);
  EXPECT_NEAR(fisherLimit(0.05, 10, 10), 2.978, 5e-4);
  EXPECT_NEAR(chiSquaredTail(18.307, 10), 0.05, 1e-5);
  EXPECT_NEAR(chiSquaredQuantile(0.95, 10), 18.307, 5e-4);
}

TEST(Distributions, AFarTailIsNotNothing) {
  EXPECT_GT(studentTail(30.0, 100.0), 0.0);
  EXPECT_LT(studentTail(30.0, 100.0), 1e-50);
  EXPECT_NEAR(normalBelow(-30.0), 4.9e-198, 1e-199);
}

TEST(Distributions, WithoutFreedomsThereIsNone) { EXPECT_THROW(studentLimit(0.05, 0.0), std::domain_error); }

}  // namespace
}  // namespace mm
