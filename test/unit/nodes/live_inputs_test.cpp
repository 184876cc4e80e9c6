#include "nodes/live_inputs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

constexpr std::int64_t kSecond = 1000000000;
constexpr std::int64_t kStart = 1000 * kSecond;

class LiveInputsTest : public ::testing::Test {
 protected:
  LiveInputsTest() {
    domain_.setMachine(machine_);
    domain_.sensors = {"motor", "bed"};
    view_ = inputs_.watch(domain_);
  }
  bool joints(std::int64_t stamp, double vx = 0.0) {
    return inputs_.takeJoints(stamp, {"x", "y", "z"}, {1.0, 2.0, 3.0}, {vx, 0.0, 0.0}, reason_);
  }
  State state() {
    State s;
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
  EXPECT_TRUE(joints(kStart, -1e-3));
  EXPECT_TRUE(joints(kStart + kSecond));
  EXPECT_EQ(state().travel, (std::vector<double>{-1.0, 0.0, 0.0}));
  EXPECT_TRUE(joints(kStart - 50 * kSecond));
  EXPECT_EQ(state().travel[0], 0.0);
}

TEST_F(LiveInputsTest, AVelocityThatIsMissingIsNotGuessed) {
  EXPECT_TRUE(joints(kStart, 1e-3));
  EXPECT_TRUE(inputs_.takeJoints(kStart + 1, {"x", "y", "z"}, {5.0, 2.0, 3.0}, {}, reason_));
  EXPECT_EQ(state().travel[0], 0.0);
  EXPECT_TRUE(std::isnan(state().velocity[0]));
}

TEST_F(LiveInputsTest, TheDriverTellsTheTravelOfAJointThatWasNotSeenToMove) {
  inputs_.takeTravel({"z", "stranger", "x"}, {1, -1, -1});
  EXPECT_TRUE(joints(kStart));
  EXPECT_EQ(state().travel, (std::vector<double>{-1.0, 0.0, 1.0}));
  EXPECT_TRUE(joints(kStart + kSecond, 1e-3));
  inputs_.takeTravel({"x"}, {-1});  // older than what was seen
  EXPECT_EQ(state().travel, (std::vector<double>{1.0, 0.0, 1.0}));
  EXPECT_TRUE(joints(kStart - 50 * kSecond));
  EXPECT_EQ(state().travel, (std::vector<double>{0.0, 0.0, 0.0}));
}

TEST_F(LiveInputsTest, NamesInAnotherOrderAndStrangers) {
  EXPECT_TRUE(inputs_.takeJoints(kStart, {"z", "gripper", "x", "y"}, {3.0, 9.0, 1.0, 2.0}, {}, reason_));
  EXPECT_EQ(state().position, (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST_F(LiveInputsTest, TemperaturesGrowOldAndAreForgottenWhenTheClockGoesBack) {
  inputs_.takeTemperature("bed", kStart, 21.5);
  inputs_.takeTemperature("nobody", kStart, 99.0);
  joints(kStart + 9 * kSecond);
  EXPECT_TRUE(std::isnan(state().temperature[0]));
  EXPECT_EQ(state().temperature[1], 21.5);
  EXPECT_FALSE(inputs_.heard(view_));
  joints(kStart + 11 * kSecond);
  EXPECT_TRUE(std::isnan(state().temperature[1]));
  joints(kStart - 5 * kSecond);
  EXPECT_TRUE(std::isnan(state().temperature[1])) << "a reading of the future";
}

TEST_F(LiveInputsTest, TimeCountsFromZeroOnceThatIsKnown) {
  joints(kStart);
  EXPECT_TRUE(std::isnan(state().time));
  inputs_.setTimeZero(kStart - 90 * kSecond);
  EXPECT_NEAR(state().time, 90.0, 1e-9);
}

TEST_F(LiveInputsTest, ALagRemembersAStep) {
  // 20 degC for 100 s, then 30 degC: after one time constant 1 - 1/e of the step.
  for (int i = 0; i <= 100; ++i) inputs_.takeTemperature("bed", kStart + i * kSecond, 20.0);
  for (int i = 1; i <= 200; ++i) inputs_.takeTemperature("bed", kStart + 100 * kSecond + i * kSecond, 30.0);
  joints(kStart + 300 * kSecond);
  const double lagged = state().history->lagged(1, 200.0, 0.0, nullptr);
  EXPECT_NEAR(lagged, 30.0 - 10.0 * std::exp(-1.0), 0.1) << "the step is a ramp of at most 5 s";
  EXPECT_TRUE(std::isnan(state().history->lagged(0, 200.0, 0.0, nullptr)));
}

TEST_F(LiveInputsTest, AContactKeepsItsOwnReadings) {
  joints(kStart, 1e-3);
  State s;
  inputs_.fill(view_, kStart, {7.0, 8.0, 9.0}, {-2e-3, 0.0, std::nan("")}, s);
  EXPECT_EQ(s.position, (std::vector<double>{7.0, 8.0, 9.0}));
  EXPECT_EQ(s.travel[0], -1.0);
}

}  // namespace
}  // namespace mm
