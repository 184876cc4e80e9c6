#include "nodes/live_inputs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

constexpr std::int64_t kOneSecond = 1000000000;
constexpr std::int64_t kBegin = 1000 * kOneSecond;

class LiveInputsTest : public ::testing::Test {
 protected:
  LiveInputsTest() {
    domain_.setMachine(machine_);
    domain_.sensors = {"motor", "bed"};
    view_ = inputs_.watch(domain_);
  }
  bool joints(std::int64_t stamp, double vx = 0.0, double x = 1.0) {
    return inputs_.takeJoints(stamp, {"x", "y", "z"}, {x, 2.0, 3.0}, {vx, 0.0, 0.0}, reason_);
  }
  MovingState state() {
    MovingState s;
    inputs_.fill(view_, s);
    return s;
  }

  Machine machine_ = Machine::load("three_axis");
  LiveInputs inputs_{machine_, {0.05, 10.0}};
  Domain domain_;
  LiveInputs::View view_;
  std::string reason_;
};

TEST_F(LiveInputsTest, TravelIsThatOfTheLastMotionUntilTheClockGoesBack) {
  EXPECT_TRUE(joints(kBegin, -1e-3));
  EXPECT_TRUE(joints(kBegin + kOneSecond));
  EXPECT_EQ(state().travel, (std::vector<double>{-1.0, 0.0, 0.0}));
  EXPECT_TRUE(joints(kBegin - 50 * kOneSecond));
  EXPECT_EQ(state().travel[0], 0.0);
}

TEST_F(LiveInputsTest, AVelocityThatIsMissingIsNotGuessed) {
  EXPECT_TRUE(joints(kBegin, 1e-3));
  EXPECT_TRUE(inputs_.takeJoints(kBegin + 1, {"x", "y", "z"}, {5.0, 2.0, 3.0}, {}, reason_));
  EXPECT_EQ(state().travel[0], 0.0);
  EXPECT_TRUE(std::isnan(state().velocity[0]));
}

TEST_F(LiveInputsTest, TheDirectionOfTravelIsTheDriversFromItsStampOn) {
  inputs_.takeTravel(0, kBegin, 1.0);
  inputs_.takeTravel(2, kBegin + kOneSecond, -1.0);
  EXPECT_TRUE(joints(kBegin));
  EXPECT_EQ(state().travel, (std::vector<double>{1.0, 0.0, 0.0})) << "z turns a second later";
  EXPECT_TRUE(joints(kBegin + kOneSecond / 10, -1e-3, 0.999));
  EXPECT_EQ(state().travel[0], -1.0) << "a reversal that was seen after what the driver told";
  inputs_.takeTravel(0, kBegin + kOneSecond, 1.0);
  EXPECT_TRUE(joints(kBegin + kOneSecond, 0.0, 0.999));
  EXPECT_EQ(state().travel, (std::vector<double>{1.0, 0.0, -1.0})) << "but it knows better";
  inputs_.takeTravel(0, kBegin + kOneSecond, 0.0);
  EXPECT_TRUE(joints(kBegin + 2 * kOneSecond, 0.0, 0.999));
  EXPECT_EQ(state().travel[0], 1.0) << "it says nothing";
  EXPECT_TRUE(joints(kBegin - 50 * kOneSecond));
  EXPECT_EQ(state().travel, (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST_F(LiveInputsTest, NamesInAnotherOrderAndStrangers) {
  EXPECT_TRUE(inputs_.takeJoints(kBegin, {"z", "gripper", "x", "y"}, {3.0, 9.0, 1.0, 2.0}, {}, reason_));
  EXPECT_EQ(state().position, (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST_F(LiveInputsTest, TemperaturesGrowOldAndAreForgottenWhenTheClockGoesBack) {
  inputs_.takeTemperature("bed", kBegin, 21.5);
  inputs_.takeTemperature("nobody", kBegin, 99.0);
  joints(kBegin + 9 * kOneSecond);
  EXPECT_TRUE(std::isnan(state().temperature[0]));
  EXPECT_EQ(state().temperature[1], 21.5);
  EXPECT_FALSE(inputs_.heard(view_));
  joints(kBegin + 11 * kOneSecond);
  EXPECT_TRUE(std::isnan(state().temperature[1]));
  joints(kBegin - 5 * kOneSecond);
  EXPECT_TRUE(std::isnan(state().temperature[1])) << "a reading of the future";
}

TEST_F(LiveInputsTest, TimeCountsFromZeroOnceThatIsKnown) {
  joints(kBegin);
  EXPECT_TRUE(std::isnan(state().time));
  inputs_.setTimeZero(kBegin - 90 * kOneSecond);
  EXPECT_NEAR(state().time, 90.0, 1e-9);
}

TEST_F(LiveInputsTest, ALagRemembersAStep) {
  // 20 degC for 100 s, then 30 degC: after one time constant 1 - 1/e of the step.
  for (int i = 0; i <= 100; ++i) inputs_.takeTemperature("bed", kBegin + i * kOneSecond, 20.0);
  for (int i = 1; i <= 200; ++i)
    inputs_.takeTemperature("bed", kBegin + 100 * kOneSecond + i * kOneSecond, 30.0);
  joints(kBegin + 300 * kOneSecond);
  const double lagged = state().history->lagged(1, 200.0, 0.0, nullptr);
  EXPECT_NEAR(lagged, 30.0 - 10.0 * std::exp(-1.0), 0.1) << "the step is a ramp of at most 5 s";
  EXPECT_TRUE(std::isnan(state().history->lagged(0, 200.0, 0.0, nullptr)));
}

TEST_F(LiveInputsTest, AContactKeepsItsOwnReadings) {
  joints(kBegin, 1e-3);
  MovingState s;
  inputs_.fill(view_, kBegin, {7.0, 8.0, 9.0}, {-2e-3, 0.0, std::nan("")}, s);
  EXPECT_EQ(s.position, (std::vector<double>{7.0, 8.0, 9.0}));
  EXPECT_EQ(s.travel[0], -1.0);
}

/// 80 s of joint states at 10 Hz beside a gripper whose clock is three seconds behind: every one gives a
/// frame.
TEST_F(LiveInputsTest, AForeignPublisherCostsNothing) {
  int frames = 0;
  for (int i = 0; i < 800; ++i) {
    frames += joints(kBegin + i * kOneSecond / 10, 1e-3, 1.0 + 1e-4 * i);
    EXPECT_FALSE(
        inputs_.takeJoints(kBegin + i * kOneSecond / 10 - 3 * kOneSecond, {"gripper"}, {0.01}, {}, reason_));
    EXPECT_EQ(reason_, "");
    EXPECT_FALSE(
        inputs_.takeJoints(kBegin + i * kOneSecond / 10 + 60 * kOneSecond, {"gripper"}, {0.01}, {}, reason_));
    EXPECT_FALSE(inputs_.takeJoints(0, {"gripper", "finger"}, {0.01}, {}, reason_)) << "wrong in itself";
    EXPECT_EQ(reason_, "");
  }
  EXPECT_EQ(frames, 800);
  EXPECT_EQ(state().travel[0], 1.0);
}

/// An encoder at rest after a motion, with a nanometre a second of noise: the direction stays.
TEST_F(LiveInputsTest, NoiseAtRestIsNoTravel) {
  std::int64_t t = kBegin;
  for (int i = 0; i <= 100; ++i) joints(t += kOneSecond / 100, -1e-3, 1.0 - 1e-5 * i);
  for (int i = 0; i < 1000; ++i) {
    joints(t += kOneSecond / 100, i % 2 ? 1e-9 : -1e-9, 0.999 + (i % 2 ? 1e-9 : -1e-9));
    ASSERT_EQ(state().travel[0], -1.0) << i;
  }
  MovingState s;
  inputs_.fill(view_, t, {0.999, 2.0, 3.0}, {1e-9, 0.0, -2e-3}, s);
  EXPECT_EQ(s.travel, (std::vector<double>{-1.0, 0.0, -1.0})) << "a contact while z moves and x rests";
}

TEST_F(LiveInputsTest, TravelSinceTheReversalIsTold) {
  std::int64_t t = kBegin;
  for (int i = 0; i <= 100; ++i) joints(t += kOneSecond / 100, 1e-3, 1.0 + 1e-5 * i);
  joints(t += kOneSecond / 100, -1e-4, 1.001 - 3e-6);
  EXPECT_EQ(state().travel[0], -1.0);
  EXPECT_NEAR(state().sinceReversal[0], 3e-6, 1e-12);
  inputs_.forgetTravel(0);
  joints(t += kOneSecond / 100, 0.0, 1.001 - 3e-6);
  EXPECT_EQ(state().travel[0], 0.0);
}

// before: the lag began anew as if settled, 6 um off in a warm-up
TEST_F(LiveInputsTest, OneBadStampOfATemperatureIsSetAside) {
  for (int i = 0; i <= 300; ++i)
    EXPECT_TRUE(inputs_.takeTemperature("bed", kBegin + i * kOneSecond, 20.0 + 0.01 * i));
  joints(kBegin + 300 * kOneSecond);
  const double before = state().history->lagged(1, 200.0, 0.0, nullptr);
  EXPECT_FALSE(inputs_.takeTemperature("bed", 0, 21.0)) << "none";
  EXPECT_FALSE(inputs_.takeTemperature("bed", kBegin + 299 * kOneSecond, 29.0)) << "a second old";
  EXPECT_EQ(state().history->lagged(1, 200.0, 0.0, nullptr), before);
  EXPECT_EQ(state().temperature[1], 23.0);
  EXPECT_TRUE(inputs_.takeTemperature("bed", kBegin + 301 * kOneSecond, 23.0));
  // a clock that went back says so again and again
  int aside = 0;
  for (int i = 0; i < 10; ++i)
    aside += !inputs_.takeTemperature("bed", kBegin + (100 + i) * kOneSecond, 22.0);
  EXPECT_EQ(aside, 4);
}

// before: 6 um beside a standard deviation of 0.02 um, after a restart in a warm-up
TEST_F(LiveInputsTest, WhatLagsBehindATemperatureIsUncertainUntilItWasHeardForLongEnough) {
  domain_.sensorLower = {20.0, 20.0};
  domain_.sensorUpper = {32.0, 30.0};
  view_ = inputs_.watch(domain_);
  const double tau = 60.0;
  double last = 1e9;
  for (int i = 0; i <= 500; ++i) {
    inputs_.takeTemperature("bed", kBegin + i * kOneSecond, 26.0);
    inputs_.takeTemperature("motor", kBegin + i * kOneSecond, 26.0);
    joints(kBegin + i * kOneSecond);
    if (i % 100 != 0) continue;
    const MovingState s = state();
    const double settled = s.history->lagged(1, tau, 0.0, nullptr);
    EXPECT_NEAR(settled, 26.0, 1e-9);
    const TemperatureHistory* other = dynamic_cast<const YoungHistory&>(*s.history).otherPast();
    if (i > 7 * tau) {
      EXPECT_EQ(other, nullptr) << "a thousandth is left";
      continue;
    }
    ASSERT_NE(other, nullptr) << i;
    const double off = other->lagged(1, tau, 0.0, nullptr) - settled;
    EXPECT_NEAR(off, 6.0 / std::sqrt(3.0) * std::exp(-i / tau), 1e-6)
        << "from 26 degC to the end of 20 to 30";
    EXPECT_LT(off, last);
    last = off;
  }
}

}  // namespace
}  // namespace mm
