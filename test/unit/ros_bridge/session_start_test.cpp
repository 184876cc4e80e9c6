#include <gtest/gtest.h>

#include "base/error.h"
#include "ros_bridge/axis_messages.h"
#include "ros_bridge/session_collector.h"

namespace mm {
namespace {

constexpr double kStart = 5000.0;  // s

ros::Time at(double t) { return ros::Time(kStart + t); }

measuring_machine::Artifact artifact(const ros::Time& stamp) {
  measuring_machine::Artifact message;
  message.header.stamp = stamp;
  message.name = "ball";
  message.pose_known = true;
  message.tip_radius = 1e-3;
  message.repeatability = 1e-6;
  message.features.resize(1);
  message.features[0].name = "b0";
  message.features[0].position_known = true;
  message.features[0].radius = 4e-3;
  return message;
}

measuring_machine::ProbeContact contact(double t, double x) {
  measuring_machine::ProbeContact message;
  message.header.stamp = at(t);
  message.name = {"x", "y", "z"};
  message.position = {x, 0.0, 0.0};
  message.velocity = {1e-3, 0.0, 0.0};
  message.laser_reading = kNotMeasured;
  message.feature = "b0";
  return message;
}

sensor_msgs::Temperature bed(double t, double value) {
  sensor_msgs::Temperature message;
  message.header.stamp = at(t);
  message.temperature = value;
  return message;
}

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

TEST(ToContactMessage, ApproachIsThatOfTheTipsMotion) {
  measuring_machine::ProbeLatch latch;
  latch.name = {"z", "x", "y"};
  latch.position = {3.0, 1.0, 2.0};
  latch.velocity = {-4e-3, 3e-3, 0.0};
  latch.laser_reading = kNotMeasured;
  latch.feature = "b0";
  const Machine machine = Machine::load("three_axis");
  const auto message = toContactMessage(latch, machine);
  EXPECT_EQ(message.name, (std::vector<std::string>{"x", "y", "z"}));
  EXPECT_EQ(message.position, (std::vector<double>{1.0, 2.0, 3.0}));
  EXPECT_NEAR(message.approach.x, 0.6, 1e-12);
  EXPECT_NEAR(message.approach.z, -0.8, 1e-12);
  latch.position.pop_back();
  EXPECT_THROW(toContactMessage(latch, machine), InputError);
}

}  // namespace
}  // namespace mm
