#include <gtest/gtest.h>

#include <cmath>

#include "base/error.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/session_collector.h"
#include "session/session_summary.h"
#include "session_messages.h"

namespace mm {
namespace {

using namespace test;

SessionCollector collectorWith(const std::vector<double>& temperaturesAt) {
  SessionCollector c("test");
  c.setMachine(Machine::load("three_axis"));
  for (const double t : temperaturesAt) c.addTemperature("bed", bed(t, 20.0 + 0.1 * t));
  c.addArtifact(artifact(at(0.0)));
  c.addContact(contact(3.0, 5e-3));
  c.addContact(contact(4.0, -5e-3));
  return c;
}

TEST(SessionStart, ARecorderStartedEarlierGivesTheSameSession) {
  const Session early = collectorWith({-50.0, -20.0, -1.0, 2.0, 9.0}).build();
  const Session late = collectorWith({-1.0, 2.0, 9.0}).build();
  EXPECT_EQ(early.epoch, late.epoch);
  ASSERT_EQ(early.observations.size(), 2u);
  EXPECT_EQ(early.observations[0].time, 3.0);
  EXPECT_EQ(early.temperatures[0].time, late.temperatures[0].time);
  EXPECT_EQ(early.temperatures[0].time, (std::vector<double>{-1.0, 2.0, 9.0}));
}

TEST(SessionStart, ContactsBeforeTheArtifactAreKept) {
  SessionCollector c = collectorWith({-1.0});
  c.addContact(contact(-10.0, 5e-3));
  const Session session = c.build();
  ASSERT_EQ(session.observations.size(), 3u);
  EXPECT_EQ(session.observations[0].time, 0.0) << "the earliest stamp is then the start";
}

TEST(SessionStart, ANewSessionForgetsTheOneBefore) {
  SessionCollector c = collectorWith({-1.0, 2.0});
  c.dropBefore(nanoseconds(at(10.0)));
  c.addArtifact(artifact(at(10.0)));
  EXPECT_EQ(c.observationCount(), 0u);
  c.addContact(contact(12.0, 5e-3));
  const Session session = c.build();
  ASSERT_EQ(session.observations.size(), 1u);
  EXPECT_EQ(session.observations[0].row, 1);
  EXPECT_EQ(session.observations[0].time, 2.0);
  EXPECT_EQ(session.temperatures[0].value, (std::vector<double>{20.2})) << "the last value still counts";
}

TEST(SessionStart, AClockThatWentBackForgetsTheFuture) {
  SessionCollector c = collectorWith({-1.0});
  c.dropAfter(nanoseconds(at(3.0)));
  EXPECT_EQ(c.observationCount(), 0u);
  c.addContact(contact(3.0, 5e-3));
  EXPECT_EQ(c.build().observations.size(), 1u);
}

sensor_msgs::JointState joints(double t, std::vector<std::string> names, double position, double velocity) {
  sensor_msgs::JointState message;
  message.header.stamp = at(t);
  message.position.assign(names.size(), position);
  message.velocity.assign(names.size(), velocity);
  message.name = std::move(names);
  return message;
}

/// One contact after the other is wrong in another way; one temperature has no stamp. The rest is the
/// session.
TEST(SetAside, OneBadMessageDoesNotCondemnTheRest) {
  SessionCollector c = collectorWith({-1.0, 2.0});
  measuring_machine::ProbeContact bad = contact(5.0, 1e-3);
  bad.position[1] = std::nan("");
  c.addContact(bad);
  bad = contact(5.0, 1e-3);
  bad.name[2] = "w";
  c.addContact(bad);
  bad = contact(5.0, 1e-3);
  bad.header.stamp = ros::Time();
  c.addContact(bad);
  bad = contact(5.0, 1e-3);
  bad.feature = "b1";
  c.addContact(bad);
  sensor_msgs::Temperature unstamped;
  unstamped.temperature = 20.0;
  c.addTemperature("bed", unstamped);
  c.addContact(contact(6.0, 3e-3));
  EXPECT_EQ(c.refusedCount(), 4u);
  Session session = c.build();
  ASSERT_EQ(session.observations.size(), 3u);
  EXPECT_EQ(session.temperatures[0].value.size(), 2u);
  ASSERT_EQ(session.setAside.size(), 5u);
  std::string all;
  for (const SetAside& aside : session.setAside) all += setAsideText(session, aside) + "\n";
  for (const char* words :
       {"/probe/contact message 3 is set aside: the reading of joint 'y' is not a number",
        "/probe/contact message 4 is set aside: joint 'w' is not a joint of machine",
        "/probe/contact message 5 is set aside: its header has no stamp",
        "/probe/contact message 6 is set aside: feature 'b1' is not in artifact 'ball'; did you mean 'b0'?",
        "/temperature/bed message 3 is set aside: its header has no stamp"})
    EXPECT_NE(all.find(words), std::string::npos) << words << "\n" << all;
  EXPECT_NE(lossText(session).find("5 are set aside, first: /probe/contact message 3"), std::string::npos);
  session.prepare();
  EXPECT_EQ(session.setAside.size(), 5u) << "a second call changes nothing";
}

TEST(SetAside, WhereNothingIsLeftTheFirstIsNamed) {
  SessionCollector c("test");
  c.setMachine(Machine::load("three_axis"));
  c.addArtifact(artifact(at(0.0)));
  measuring_machine::ProbeContact bad = contact(5.0, 1e-3);
  bad.position[1] = std::nan("");
  c.addContact(bad);
  try {
    c.build();
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("/probe/contact message 1: the reading of joint 'y'"),
              std::string::npos)
        << e.what();
  }
}

/// A gripper with a clock of its own moves neither the session's start nor anything else.
TEST(JointStates, AForeignPublisherSaysNothing) {
  const Session alone = collectorWith({-1.0}).build();
  SessionCollector c("test");
  for (int i = 0; i < 20; ++i)
    c.addJointState(joints(-4000.0 + i, {"gripper"}, 0.01 * (i % 2), 0.1), "/gripper");
  c.setMachine(Machine::load("three_axis"));
  for (int i = 0; i < 20; ++i)
    c.addJointState(joints(-3000.0 + i, {"gripper"}, 0.01 * (i % 2), 0.1), "/gripper");
  c.addContact(contact(3.0, 5e-3));
  c.addContact(contact(4.0, -5e-3));
  measuring_machine::Artifact plate = artifact(ros::Time());
  c.addArtifact(plate);
  const Session session = c.build();
  EXPECT_EQ(session.observations[0].time, 0.0);
  EXPECT_EQ(session.epoch, alone.epoch + 3.0);
}

/// Another publisher goes the other way before a contact at standstill, and is believed only where no driver
/// says that the joint is its own, and it was heard first.
TEST(JointStates, OfAStrangerSayNothingOfTravel) {
  measuring_machine::AxisStatus status;
  status.name = {"x", "y", "z"};
  measuring_machine::ProbeContact touch = contact(10.0, 5e-3);
  touch.velocity = {0.0, 0.0, 0.0};
  enum class Order { kDriverFirst, kStrangerFirst, kStatusLast, kNoStatus, kNoStatusStrangerFirst };
  for (const Order order : {Order::kDriverFirst, Order::kStrangerFirst, Order::kStatusLast, Order::kNoStatus,
                            Order::kNoStatusStrangerFirst}) {
    SessionCollector c("test");
    c.setMachine(Machine::load("three_axis"));
    c.addArtifact(artifact(at(0.0)));
    const auto stranger = [&] {
      for (int i = 0; i < 50; ++i)
        c.addJointState(joints(5.0 + 0.01 * i, {"x", "y", "z"}, -1e-4 * i, -1e-2), "/stray");
    };
    const auto driver = [&] {
      for (int i = 0; i < 50; ++i)
        c.addJointState(joints(1.0 + 0.01 * i, {"x", "y", "z"}, 1e-4 * i, 1e-2), "/axis_driver");
    };
    const bool told = order != Order::kNoStatus && order != Order::kNoStatusStrangerFirst;
    if (told && order != Order::kStatusLast) c.addStatus(status, "/axis_driver");
    if (order == Order::kStrangerFirst || order == Order::kNoStatusStrangerFirst) stranger();
    driver();
    if (order != Order::kStrangerFirst && order != Order::kNoStatusStrangerFirst) stranger();
    if (order == Order::kStatusLast) c.addStatus(status, "/axis_driver");
    c.addContact(touch);
    const double travel = order == Order::kNoStatusStrangerFirst ? -1.0 : 1.0;
    EXPECT_EQ(c.build().observations[0].travel, (std::vector<double>(3, travel))) << static_cast<int>(order);
  }
}

/// An encoder at rest that says a nanometre a second, up and down, for an hour at 100 Hz: none of it is kept.
TEST(JointStates, NoiseAtRestIsNeitherKeptNorTravel) {
  SessionCollector c("test");
  c.setMachine(Machine::load("three_axis"));
  c.addArtifact(artifact(at(0.0)));
  TravelLog kept;
  const auto say = [&](const sensor_msgs::JointState& state) {
    c.addJointState(state, "/axis_driver");
    kept.take(state, "/axis_driver", nullptr, 0);
  };
  for (int i = 0; i < 200; ++i) say(joints(0.01 * i, {"x", "y", "z"}, 1e-5 * i, 1e-3));
  for (int i = 200; i < 360000; ++i)
    say(joints(0.01 * i, {"x", "y", "z"}, 2e-3 + (i % 2 ? 1e-9 : -1e-9), i % 2 ? 1e-9 : -1e-9));
  for (const char* joint : {"x", "y", "z"})
    EXPECT_EQ(kept.motions(joint).size(), 1u) << "the first direction of joint " << joint;
  measuring_machine::ProbeContact touch = contact(3000.0, 5e-3);
  touch.velocity = {-1e-9, 1e-9, -2e-3};
  c.addContact(touch);
  EXPECT_EQ(c.build().observations[0].travel, (std::vector<double>{1.0, 1.0, -1.0}));
}

TEST(Names, OfSensorsMayHaveSpaces) {
  EXPECT_EQ(topicOf("motor left (1)"), "motor_left__1_");
  EXPECT_EQ(sensorOf("motor_left", "motor left"), "motor left");
  EXPECT_EQ(sensorOf("bed", "table"), "bed");
  EXPECT_EQ(sensorOf("bed", ""), "bed");
  SessionCollector c = collectorWith({-1.0, 2.0});
  sensor_msgs::Temperature warm = bed(2.0, 21.0);
  warm.header.frame_id = "motor left";
  c.addTemperature("motor_left", warm);
  const Session session = c.build();
  ASSERT_EQ(session.temperatures.size(), 2u);
  EXPECT_EQ(session.temperatures[1].name, "motor left");
}

TEST(Homing, IsToldByTheJointStateItself) {
  AxesState state;
  state.position = {0.0};
  state.velocity = {0.0};
  state.homed = true;
  sensor_msgs::JointState message = toJointState({"x"}, state, at(1.0), "m1/");
  EXPECT_EQ(message.header.frame_id, "m1/workpiece") << "a frame of the tree";
  EXPECT_TRUE(homingOf(message).told && homingOf(message).homed);
  EXPECT_TRUE(homingOf(message).at.isZero()) << "its status says when";
  state.homed = false;
  message = toJointState({"x"}, state, at(1.0), "m1/");
  EXPECT_EQ(message.header.frame_id, "m1/unhomed") << "a frame that no tree has";
  EXPECT_TRUE(homingOf(message).told);
  EXPECT_FALSE(homingOf(message).homed);
  message.header.frame_id = "homed at 1795316193.000000007";  // as in older recordings
  EXPECT_EQ(homingOf(message).at, ros::Time(1795316193, 7));
  message.header.frame_id = "not homed";
  EXPECT_TRUE(homingOf(message).told && !homingOf(message).homed);
  EXPECT_FALSE(homingOf(sensor_msgs::JointState()).told) << "a driver of others";
}

}  // namespace
}  // namespace mm
