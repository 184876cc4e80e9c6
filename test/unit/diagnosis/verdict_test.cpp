#include "diagnosis/verdict.h"

#include <gtest/gtest.h>

#include <cmath>

#include "diagnosis/noise_words.h"
#include "diagnosis/wording.h"
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

// Memory that is shorter than the time between two measurements is none: it is scatter.
TEST(DecidedVerdict, WhatIsQuickerThanTheMeasurementsIsScatter) {
  Diagnosis d = test_support::verdict(Verdict::kExplained);
  d.drift = {test_support::wander()};  // 0.4 um, where the repeatability is 0.3 um
  decide(d);
  EXPECT_EQ(d.verdict, Verdict::kExplained) << "a drift of minutes is told beside it";
  d.drift[0].quick = true;
  d.drift[0].quickStd = d.drift[0].std;
  decide(d);
  EXPECT_EQ(d.verdict, Verdict::kScatter);
  EXPECT_NE(sentenceOf(d).find("x scatters by 0.4 um RMS from one measurement to the next, 1.33 times the "
                               "repeatability of 0.3 um (declared)"),
            std::string::npos)
      << sentenceOf(d);
  d.drift[0].ofThePlace = true;
  EXPECT_NE(sentenceOf(d).find("x scatters by 0.4 um RMS from one place to the next"), std::string::npos);
  EXPECT_NE(sentenceOf(d).find("the runs agree, so it depends on the position"), std::string::npos);
  d.drift[0].ofThePlace = false;
  EXPECT_EQ(driftAdvice(d.drift[0]).find("every"), std::string::npos) << driftAdvice(d.drift[0]);
  d.drift[0].quickStd = 0.38e-6;
  decide(d);
  EXPECT_EQ(d.verdict, Verdict::kExplained) << "within the factor of 1.3, whatever the slow part";
}

}  // namespace
}  // namespace mm
