// What a session lacks is told, and what a collector keeps has bounds.
#include <gtest/gtest.h>

#include "ros_bridge/bounded_log.h"
#include "ros_bridge/session_collector.h"
#include "session_messages.h"

namespace mm {
namespace {

using namespace test;

measuring_machine::Measured measured(const ros::Time& session, std::uint32_t contacts) {
  measuring_machine::Measured message;
  message.header.stamp = session;
  message.contacts = contacts;
  return message;
}

/// With contacts at 1, 2, … `contacts` seconds.
SessionCollector collector(int contacts, std::size_t most = 0) {
  SessionCollector c("test");
  if (most > 0) c.bound(most);
  c.setMachine(Machine::load("three_axis"));
  c.addArtifact(artifact(at(0.0)));
  for (int i = 1; i <= contacts; ++i) c.addContact(contact(i));
  return c;
}

bool says(const std::string& text, const std::string& words) { return text.find(words) != std::string::npos; }

TEST(Measured, WhatIsMissingIsTold) {
  SessionCollector c = collector(3);
  c.addMeasured(measured(at(0.0), 3));
  EXPECT_EQ(c.build().warning, "");
  c.addMeasured(measured(at(0.0), 5));
  EXPECT_TRUE(says(c.build().warning, "3 of 5 measured contacts were received")) << c.build().warning;
}

TEST(Measured, APlanThatWasOverIsNotMissed) {
  SessionCollector c("test");
  c.setMachine(Machine::load("three_axis"));
  c.addMeasured(measured(at(-100.0), 24));  // latched, of the plan before
  c.addArtifact(artifact(at(0.0)));
  c.addContact(contact(1.0));
  c.addMeasured(measured(at(0.0), 1));
  EXPECT_EQ(c.build().warning, "");
}

TEST(Measured, APlanThatWentOnElsewhereCountsWithItsBeginning) {
  SessionCollector c = collector(3);
  c.addMeasured(measured(at(0.0), 4));
  c.addMeasured(measured(ros::Time(), 2));
  EXPECT_TRUE(says(c.build().warning, "3 of 6 measured contacts")) << c.build().warning;
}

TEST(Measured, AContactThatIsSetAsideIsHere) {
  SessionCollector c = collector(2);
  measuring_machine::ProbeContact wrong = contact(3.0);
  wrong.feature.clear();
  c.addContact(wrong);
  c.addMeasured(measured(at(0.0), 3));
  EXPECT_EQ(c.build().warning, "");
}

TEST(SessionBounds, MeasurementsBeyondAreSetAsideAndTold) {
  const SessionCollector c = collector(12, 10);
  EXPECT_EQ(c.observationCount(), 10u);
  EXPECT_EQ(c.refusedCount(), 2u);
  ASSERT_FALSE(c.refused().empty());
  EXPECT_TRUE(says(c.refused().front(), "the session has 10 measurements")) << c.refused().front();
  EXPECT_EQ(collector(12).observationCount(), 12u) << "a bag is read whole";
}

TEST(SessionBounds, OfWhatIsSetAsideAThousandAreKept) {
  const SessionCollector c = collector(3000, 10);
  EXPECT_EQ(c.refused().size(), 1000u);
  EXPECT_EQ(c.refusedCount(), 2990u);
  EXPECT_TRUE(says(c.build().warning, "1990 more messages were set aside")) << c.build().warning;
}

TEST(SessionBounds, WhatWasLoggedBeforeTheSessionGoesFirst) {
  SessionCollector c("test");
  c.bound(100);
  c.setMachine(Machine::load("three_axis"));
  for (int i = 0; i < 1000; ++i) c.addTemperature("bed", bed(-1000.0 + i));
  c.addArtifact(artifact(at(0.0)));
  c.dropBefore(nanoseconds(at(0.0)));
  c.addContact(contact(1.0));
  for (int i = 0; i < 90; ++i) c.addTemperature("bed", bed(i));
  const Session session = c.build();
  EXPECT_EQ(session.warning, "");
  EXPECT_GE(session.temperatures[0].time.size(), 90u);
  for (int i = 90; i < 300; ++i) c.addTemperature("bed", bed(i));
  EXPECT_TRUE(says(c.build().warning, "the oldest of the session, have been dropped")) << c.build().warning;
  EXPECT_LE(c.build().temperatures[0].time.size(), 100u);
}

TEST(SessionBounds, NamesThatAnybodyMayMakeUp) {
  SessionCollector c = collector(1, 5000);
  measuring_machine::Covariate made;
  made.header.stamp = at(1.0);
  for (int i = 0; i < 1100; ++i) {
    made.name = "c" + std::to_string(i);
    c.addCovariate(made);
  }
  EXPECT_EQ(c.build().covariates.size(), 1000u);
  EXPECT_EQ(c.refusedCount(), 100u);
}

TEST(BoundedLog, NothingOfTheSessionGoesWhereMoreLiesBefore) {
  std::vector<std::int64_t> log;
  const auto stamp = [](std::int64_t t) { return t; };
  for (std::int64_t t = -80; t < 20; ++t) log.push_back(t);
  EXPECT_EQ(makeRoom(log, 100, 0, stamp), 0u);
  EXPECT_EQ(log.front(), -1) << "the last one before still counts";
  EXPECT_EQ(makeRoom(log, 21, 0, stamp), 9u);
  EXPECT_EQ(log.size(), 11u);
  EXPECT_EQ(makeRoom(log, 0, 0, stamp), 0u) << "without bound";
}

}  // namespace
}  // namespace mm
