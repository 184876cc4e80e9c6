#include "diagnosis/verdict.h"

#include <gtest/gtest.h>

#include <cmath>

#include "made_up_diagnosis.h"

namespace mm {
namespace {

Verdict decided(const std::string& from, double dof, double timesTheRepeatability) {
  Diagnosis d = test_support::verdict(Verdict::kScatter);
  d.base.repeatabilityFrom = from;
  d.base.repeated.dof = dof;
  d.noise = timesTheRepeatability * d.base.repeatability;
  decide(d);
  return d.verdict;
}

TEST(DecidedVerdict, OfAStatedRepeatabilityAThirdMoreIsTheSame) {
  EXPECT_EQ(decided("declared", 0.0, 1.29), Verdict::kExplained);
  EXPECT_EQ(decided("declared", 0.0, 1.31), Verdict::kScatter);
  EXPECT_EQ(decided("estimated", 0.0, 1.0), Verdict::kScatter) << "of the session itself: it says nothing";
}

// Quantiles of chi squared at 0.01, from tables: 10.196 of 23 degrees of freedom, 70.065 of 100.
TEST(DecidedVerdict, OfFewRepeatsItIsAsFarAsChanceWouldGo) {
  EXPECT_EQ(decided("repeated", 23.0, std::sqrt(23.0 / 10.196) - 0.01), Verdict::kExplained);
  EXPECT_EQ(decided("repeated", 23.0, std::sqrt(23.0 / 10.196) + 0.01), Verdict::kScatter);
  EXPECT_LT(std::sqrt(100.0 / 70.065), 1.3);
  EXPECT_EQ(decided("repeated", 100.0, 1.29), Verdict::kExplained) << "no stricter than a stated one";
}

}  // namespace
}  // namespace mm
