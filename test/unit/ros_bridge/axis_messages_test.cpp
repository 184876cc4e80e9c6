#include "ros_bridge/axis_messages.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace mm {
namespace {

measuring_machine::ProbeLatch latch(const std::vector<std::string>& names, double time, double velocity,
                                    double uncertainty = 1e-6) {
  measuring_machine::ProbeLatch message;
  message.header.stamp = ros::Time(time);
  message.probing = true;
  message.name = names;
  message.position.assign(names.size(), 0.001);
  message.velocity.assign(names.size(), velocity);
  message.laser_reading = std::nan("");
  message.time_uncertainty = uncertainty;
  return message;
}

TEST(ContactOf, SynchronisedLatchesOfTwoControllersAreOneContact) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  const std::vector<measuring_machine::ProbeLatch> others = {latch({"z"}, 99.0, 0.0),
                                                             latch({"z"}, 100.00001, 3e-3)};
  const auto contact = contactOf(first, others, {}, machine, {});
  EXPECT_EQ(contact.name, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_EQ(contact.velocity[2], 3e-3) << "the latch of the same trip, not the earlier one";
  EXPECT_EQ(contact.position.size(), 3u);
}

TEST(ContactOf, ThoseThatAreNotSynchronisedAreRefused) {
  const Machine machine = Machine::load("three_axis");
  const auto first = latch({"x", "y"}, 100.0, 3e-3);
  for (const auto& other : {latch({"z"}, 100.001, 3e-3), latch({"z"}, 100.0, 3e-3, 1e-3)}) {
    try {
      contactOf(first, {other}, {}, machine, {});
      FAIL() << "3 um of way between the latches";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("joint 'z' was latched by another controller"), std::string::npos)
          << e.what();
    }
  }
  EXPECT_EQ(contactOf(first, {latch({"z"}, 100.001, 0.0)}, {}, machine, {}).name.size(), 3u)
      << "a joint at rest";
  EXPECT_THROW(contactOf(first, {}, {}, machine, {}), InputError) << "not latched at all";
}

TEST(ContactOf, OnlyOfAProbingMoveAndWithALatchedPosition) {
  const Machine machine = Machine::load("three_axis");
  const auto refusal = [&](const measuring_machine::ProbeLatch& trip) {
    try {
      contactOf(trip, {}, {}, machine, {});
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  auto trip = latch({"x", "y", "z"}, 100.0, 3e-3);
  EXPECT_EQ(refusal(trip), "");
  trip.probing = false;
  EXPECT_NE(refusal(trip).find("possibly a collision"), std::string::npos);
  trip.laser_reading = 0.0;
  EXPECT_EQ(refusal(trip), "") << "the reading of a laser needs no move";
  trip = latch({"x", "y", "z"}, 100.0, 3e-3);
  for (const std::vector<double>& position :
       {std::vector<double>{}, std::vector<double>{1.0, std::nan(""), 0.0}}) {
    trip.position = position;
    EXPECT_NE(refusal(trip).find("latched no position"), std::string::npos);
  }
}

TEST(ContactOf, ApproachIsThatOfTheTipsMotion) {
  measuring_machine::ProbeLatch trip;
  trip.probing = true;
  trip.name = {"z", "x", "y"};
  trip.position = {3.0, 1.0, 2.0};
  trip.velocity = {-4e-3, 3e-3, 0.0};
  trip.laser_reading = std::nan("");
  trip.feature = "b0";
  const Machine machine = Machine::load("three_axis");
  const auto message = contactOf(trip, {}, {}, machine, {});
  EXPECT_EQ(message.name, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_EQ(message.position, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_NEAR(message.approach.x, 0.6, 1e-12);
  EXPECT_NEAR(message.approach.z, -0.8, 1e-12);
  trip.velocity[0] = std::nan("");
  const auto unknown = contactOf(trip, {}, {}, machine, {});
  EXPECT_EQ(unknown.approach.x * unknown.approach.x + unknown.approach.z * unknown.approach.z, 0.0);
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
    resting_.take(status, "/b_driver");
  }
  void states(double from, double to, double velocity = 0.0, const std::string& publisher = "/b_driver") {
    for (double t = from; t < to; t += 0.01) {
      sensor_msgs::JointState state;
      state.header.stamp = ros::Time(t);
      state.name = {"z"};
      state.position = {0.001 + velocity * (t - from)};
      resting_.take(state, publisher);
    }
  }
  std::string refusal(const std::vector<measuring_machine::ProbeLatch>& others = {}) {
    try {
      contactOf(first_, others, resting_, machine_, {});
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }
  void expectRefused(const std::string& words) {
    const std::string said = refusal();
    EXPECT_NE(said.find("joint 'z' was not latched, and it is not certain that it stood still: " + words),
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
  const auto contact = contactOf(first_, {}, resting_, machine_, {});
  EXPECT_EQ(contact.name.back(), "z");
  EXPECT_EQ(contact.position.back(), 0.001);
  EXPECT_EQ(contact.velocity.back(), 0.0);
  EXPECT_EQ(refusal({latch({"z"}, 99.0, 1e-3)}), "") << "a latch of another trip does not count against it";
}

TEST_F(AJointThatNobodyLatched, IsWhereItsDriverSaysWhateverAnotherPublisherSays) {
  says(99.0, false);
  states(98.0, 100.2, 1e-3, "/stray");
  expectRefused("no driver reports its position");
  states(98.0, 100.2);
  EXPECT_EQ(contactOf(first_, {}, resting_, machine_, {}).position.back(), 0.001);
}

TEST_F(AJointThatNobodyLatched, IsRefusedInMotion) {
  says(99.0, true);
  states(98.0, 100.2, 1e-3);
  expectRefused("its driver reports that it is moving");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWhereItBeganToMoveAroundTheContact) {
  says(99.0, false);
  says(100.03, true);
  states(98.0, 100.2);
  expectRefused("its driver reports that it is moving");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWhereItsStatesShowMotionThatItsDriverDoesNot) {
  says(99.0, false);
  states(98.0, 100.2, 1e-5);
  expectRefused("it moved by 1.4 um in the 140 ms around it; wire the probe's switch");
}

TEST_F(AJointThatNobodyLatched, IsRefusedWithoutStatesOnBothSidesOrWithoutAZero) {
  says(99.0, false);
  expectRefused("no driver reports its position");
  states(98.0, 100.05);
  expectRefused("there is no joint state behind the contact");
  resting_ = {};
  says(99.0, false);
  states(99.95, 100.2);
  expectRefused("there is no joint state before the contact");
  states(98.0, 100.2);  // the clock went back
  says(98.0, false, false);
  expectRefused("its driver reports that it is not homed");
  says(99.0, false, true, "does not answer");
  expectRefused("its driver says: does not answer");
}

}  // namespace
}  // namespace mm
