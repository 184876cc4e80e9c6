#include "ros_bridge/axis_messages.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace mm {
namespace {

measuring_machine::ProbeLatch latch(const std::vector<std::string>& names, double time, double velocity,
                                    double uncertainty = 1e-6) {
  measuring_machine::ProbeLatch message;
  message.header.stamp = ros::Time(time);
  message.closed = true;
  message.name = names;
  message.position.assign(names.size(), 0.001);
  message.velocity.assign(names.size(), velocity);
  message.laser_reading = std::nan("");
  message.time_uncertainty = uncertainty;
  return message;
}

TEST(JoinLatches, SynchronisedLatchesOfTwoControllersAreOneContact) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  const std::vector<measuring_machine::ProbeLatch> others = {latch({"z"}, 99.0, 0.0),
                                                             latch({"z"}, 100.00001, 3e-3)};
  const auto joined = joinLatches(first, others, {}, machine, {});
  EXPECT_EQ(joined.name, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_EQ(joined.velocity[2], 3e-3) << "the latch of the same trip, not the earlier one";
  EXPECT_EQ(toContactMessage(joined, machine).position.size(), 3u);
}

TEST(JoinLatches, ThoseThatAreNotSynchronisedAreRefused) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  for (const auto& other : {latch({"z"}, 100.001, 3e-3), latch({"z"}, 100.0, 3e-3, 1e-3)}) {
    try {
      joinLatches(first, {other}, {}, machine, {});
      FAIL() << "3 um of way between the latches";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("joint 'z' was latched by another controller"), std::string::npos)
          << e.what();
    }
  }
  EXPECT_EQ(joinLatches(first, {latch({"z"}, 100.001, 0.0)}, {}, machine, {}).name.size(), 3u)
      << "a joint at rest";
  EXPECT_THROW(joinLatches(first, {}, {}, machine, {}), InputError) << "not latched at all";
}

/// Joint states of z, a hundred a second, around a contact at 100 s, and what its driver says.
class AJointThatNobodyLatched : public ::testing::Test {
 protected:
  void says(double time, bool moving, bool homed = true, const std::string& fault = {}) {
    measuring_machine::AxisStatus status;
    status.header.stamp = ros::Time(time);
    status.name = {"z"};
    status.moving = moving;
    status.homed = homed;
    status.fault = fault;
    resting_.take(status);
  }
  void states(double from, double to, double velocity = 0.0) {
    for (double t = from; t < to; t += 0.01) {
      sensor_msgs::JointState state;
      state.header.stamp = ros::Time(t);
      state.name = {"z"};
      state.position = {0.001 + velocity * (t - from)};
      resting_.take(state);
    }
  }
  std::string refusal(const std::vector<measuring_machine::ProbeLatch>& others = {}) {
    try {
      joinLatches(first_, others, resting_, machine_, {});
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
  void expectRefused(const std::string& words) {
    const std::string said = refusal();
    EXPECT_NE(said.find("joint 'z' was not latched, and it cannot be said that it rested: " + words),
              std::string::npos)
        << said;
  }
  Machine machine_ = Machine::load("three_axis");
  measuring_machine::ProbeLatch first_ = latch({"x", "y"}, 100.0, 3e-3, 0.02);
  RestingJoints resting_;
};

TEST_F(AJointThatNobodyLatched, IsWhereItsStatesSayIfItRests) {
  says(99.0, false);
  states(98.0, 100.2);
  const auto joined = joinLatches(first_, {}, resting_, machine_, {});
  EXPECT_EQ(joined.name.back(), "z");
  EXPECT_EQ(joined.position.back(), 0.001);
  EXPECT_EQ(joined.velocity.back(), 0.0);
  EXPECT_GT(joined.time_uncertainty, 0.139) << "as far as the states are from the earliest and latest trip";
  EXPECT_LT(joined.time_uncertainty, 0.17);
  EXPECT_EQ(toContactMessage(joined, machine_).position[2], 0.001);
  EXPECT_EQ(refusal({latch({"z"}, 99.0, 1e-3)}), "") << "a latch of another trip does not count against it";
}

TEST_F(AJointThatNobodyLatched, IsRefusedInMotion) {
  says(99.0, true);
  states(98.0, 100.2, 1e-3);
  expectRefused("its driver says that it moves");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWhereItBeganToMoveAroundTheContact) {
  says(99.0, false);
  says(100.03, true);
  states(98.0, 100.2);
  expectRefused("its driver says that it moves");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWhereItsStatesShowMotionThatItsDriverDoesNot) {
  says(99.0, false);
  states(98.0, 100.2, 1e-5);
  expectRefused("it moved by 1.4 um in the 140 ms around it; wire the probe's switch");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWithoutStatesOnBothSidesOrWithoutAZero) {
  says(99.0, false);
  expectRefused("no driver tells where it is");
  states(98.0, 100.05);
  expectRefused("there is no joint state behind the contact");
  EXPECT_FALSE(resting_.heard("z", restTo(first_)));
  resting_.forget();
  says(99.0, false);
  states(99.95, 100.2);
  expectRefused("there is no joint state before the contact");
  EXPECT_TRUE(resting_.heard("z", restTo(first_)));
  states(98.0, 100.2);  // the clock went back
  says(98.0, false, false);
  expectRefused("its driver says that it is not homed");
  says(99.0, false, true, "does not answer");
  expectRefused("its driver says: does not answer");
}

}  // namespace
}  // namespace mm
