#include "drivers/temperature_trust.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

using Doubt = TemperatureTrust::Doubt;

/// A sensor that is read twice a second.
class Trust : public ::testing::Test {
 protected:
  /// @return how many of the readings in this time were believed.
  int reads(double value, double seconds) {
    int believed = 0;
    for (double t = 0.0; t < seconds; t += 0.5) {
      now_ += 0.5;
      noise_ = 0.0013 - noise_;  // no two in a row are the same
      believed += trust_.take({value + noise_, {}}, now_) ? 1 : 0;
    }
    return believed;
  }
  /// The same value to the last bit.
  int stands(double value, double seconds) {
    int believed = 0;
    for (double t = 0.0; t < seconds; t += 0.5) believed += trust_.take({value, {}}, now_ += 0.5) ? 1 : 0;
    return believed;
  }
  void fails(double seconds) {
    for (double t = 0.0; t < seconds; t += 0.5)
      EXPECT_FALSE(trust_.take({std::nan(""), "no answer"}, now_ += 0.5));
  }
  void expectSays(const std::string& said, const std::string& words) const {
    EXPECT_NE(said.find(words), std::string::npos) << said << " lacks: " << words;
  }

  TemperatureTrust trust_{"bed", {}};
  double now_ = 1.7e9, noise_ = 0.0;
};

TEST_F(Trust, AWrongValueThatStaysIsNeverBelieved) {
  EXPECT_EQ(reads(20.3, 5), 10);
  EXPECT_EQ(reads(40.3, 0.5), 0);
  EXPECT_EQ(trust_.doubt(), Doubt::kJumped);
  expectSays(trust_.why(),
             "sensor 'bed' jumped by 20.0 K in 0.5 s (~fastest is 1 K/s) to 40.30 degC; it is believed "
             "again when it reads 20.3 degC to 1 K, or by the service ~accept");
  const std::string first = trust_.why();
  EXPECT_EQ(reads(40.3, 24 * 3600), 0) << "a day";
  EXPECT_EQ(trust_.why(), first);
}

TEST_F(Trust, NeitherASilenceNorNonsenseBetweenMakesItRight) {
  reads(20.3, 5);
  reads(40.3, 5);
  fails(3600);
  EXPECT_EQ(trust_.doubt(), Doubt::kNoAnswer);
  EXPECT_EQ(reads(40.3, 60), 0);
  EXPECT_EQ(trust_.doubt(), Doubt::kJumped);
  EXPECT_EQ(reads(850.0, 60), 0);
  EXPECT_EQ(trust_.doubt(), Doubt::kNoTemperature);
  EXPECT_EQ(reads(40.3, 60), 0);
  EXPECT_EQ(reads(20.4, 0.5), 1);
}

TEST_F(Trust, AfterNonsenseItMustComeBackToo) {
  reads(20.3, 5);
  reads(850.0, 60);
  EXPECT_EQ(reads(40.3, 60), 0) << "the minute was no silence";
  expectSays(
      trust_.why(),
      "reads 40.30 degC after implausible values, 20.0 K from its value before them; it is believed again");
  EXPECT_EQ(reads(20.9, 5), 10);
}

TEST_F(Trust, ItComesBackByItself) {
  reads(20.3, 5);
  reads(40.3, 60);
  EXPECT_EQ(reads(20.6, 0.5), 1);
  expectSays(trust_.remark(),
             "sensor 'bed' is believed again: it reads 20.60 degC, 0.30 K from what it was 60 s ago");
  EXPECT_EQ(trust_.why(), "");
  EXPECT_EQ(reads(20.6, 0.5), 1);
  EXPECT_EQ(trust_.remark(), "");
}

TEST_F(Trust, ItComesBackToABodyThatHasDriftedMeanwhileButOnlyByAJump) {
  reads(20.3, 5);
  reads(40.3, 1800);
  EXPECT_EQ(reads(23.3, 5), 10) << "3 K in half an hour";
  reads(40.3, 3600);
  EXPECT_EQ(reads(28.3, 5), 0) << "5 K from where it was";
  EXPECT_EQ(reads(24.0, 5), 10);
  EXPECT_EQ(reads(26.5, 3600), 0) << "a wrong value of 2.5 K that stays does not become right by drift";
}

TEST_F(Trust, SomebodyWhoHasExchangedTheSensorSaysSo) {
  reads(20.3, 5);
  EXPECT_EQ(trust_.accept(), "") << "nothing to say";
  reads(23.3, 60);
  expectSays(trust_.accept(), "sensor 'bed' is believed at 23.30 degC");
  EXPECT_EQ(reads(23.3, 5), 10);
  EXPECT_EQ(reads(20.3, 5), 0) << "now that is wrong";
}

TEST_F(Trust, WhatNoSensorCanReadIsNotAccepted) {
  reads(20.3, 5);
  reads(850.0, 5);
  EXPECT_EQ(trust_.accept(), "");
  EXPECT_EQ(reads(850.0, 5), 0);
}

TEST_F(Trust, OverASilenceItMayHaveWarmedAsFastAsABodyCan) {
  reads(20.3, 5);
  fails(10);
  EXPECT_EQ(reads(40.3, 5), 0) << "20 K in 10 s";
  reads(20.3, 5);
  now_ += 3600;
  EXPECT_EQ(reads(12.3, 0.5), 1) << "the room has changed in an hour";
  expectSays(trust_.remark(), "reads 12.30 degC, -8.0 K from what it was before it was not heard for 3600 s");
  EXPECT_EQ(trust_.toLookAt(), trust_.remark());
  EXPECT_EQ(reads(12.3, 5), 10);
  EXPECT_EQ(trust_.remark(), "") << "said once";
  EXPECT_NE(trust_.toLookAt(), "") << "until somebody has looked";
  expectSays(trust_.accept(), "sensor 'bed' was looked at");
  EXPECT_EQ(trust_.toLookAt(), "");
}

TEST_F(Trust, WhatWarmsAsABodyDoesIsBelieved) {
  double value = 20.0;
  for (int i = 0; i < 200; ++i) EXPECT_EQ(reads(value += 0.4, 0.5), 1) << value;
}

TEST_F(Trust, AFrozenSensorIsSilentSinceItsLastChange) {
  reads(20.301, 5);
  stands(20.301, 1799);
  EXPECT_EQ(trust_.doubt(), Doubt::kNone);
  EXPECT_EQ(stands(20.301, 3600), 1) << "the reading before the 1800th second";
  EXPECT_EQ(trust_.doubt(), Doubt::kFrozen);
  EXPECT_EQ(reads(24.3, 5), 10) << "what changed in an hour that nobody saw";
}

TEST_F(Trust, ACoarseSensorMayStandForLongInASteadyRoom) {
  const int day = 2 * 24 * 3600;
  EXPECT_EQ(stands(21.5, 24 * 3600), day) << "steps of 0.5 K";
  EXPECT_EQ(trust_.step(), 0.5);
  stands(21.5, 3600.5);
  EXPECT_EQ(trust_.doubt(), Doubt::kFrozen) << "50 times as long as one of 0.01 K";
  expectSays(trust_.why(), "is frozen: its value has not changed for 90000 s (90000 s in steps of 0.5 K)");
  EXPECT_EQ(stands(22.0, 0.5), 1);
  TemperatureTrust whole("cpu", {}), tenth("coolant", {}), chip("air", {}), fine("spindle", {});
  for (const double value : {21.0, 22.0}) whole.take({value, {}}, now_);
  for (const double value : {21.0, 21.3}) tenth.take({value, {}}, now_);
  for (const double value : {21.0, 21.0625}) chip.take({value, {}}, now_);
  for (const double value : {21.0, 21.037}) fine.take({value, {}}, now_);
  EXPECT_EQ(whole.step(), 1.0);
  EXPECT_EQ(tenth.step(), 0.1);
  EXPECT_EQ(chip.step(), 0.0625);
  EXPECT_EQ(fine.step(), 0.0);
}

TEST_F(Trust, AClockThatGoesBackKnowsNothingOfBeforeExceptThatTheSensorIsWrong) {
  reads(20.3, 5);
  now_ -= 1000;
  EXPECT_EQ(reads(24.3, 5), 10) << "a replay that begins again";
  reads(44.3, 5);
  now_ -= 1000;
  EXPECT_EQ(reads(44.3, 5), 0);
  EXPECT_EQ(reads(24.3, 5), 10);
}

TEST_F(Trust, ZeroSwitchesEachCheckOff) {
  trust_ = TemperatureTrust("bed", {0.0, 0.0});
  EXPECT_EQ(reads(20.0, 0.5) + reads(90.0, 0.5) + stands(20.123, 7200), 2 + 14400);
  EXPECT_EQ(trust_.remark(), "");
}

}  // namespace
}  // namespace mm
