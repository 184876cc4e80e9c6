#include "session/joined.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "session/session_hash.h"
#include "session_files.h"
#include "turned_plate.h"

namespace mm {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string refusal(const Session& a, const Session& b) {
  return test::messageOf<InputError>([&] { joined({a, b}); });
}

TEST(Joined, OneSessionIsItself) {
  const Session s = test::TurnedPlate(1).session("a.bag", {0.0});
  EXPECT_EQ(sessionHash(joined({s})), sessionHash(s));
}

TEST(Joined, KeepsWhatBelongsToEachSession) {
  test::TurnedPlate plate(2);
  Session a = plate.session("a.bag", {0.0}, 0, false), b = plate.session("b.bag", {0.0}, 0, false);
  b.rowFile = "b.csv";
  a.temperatures.push_back({"bed", "degC", {0.0, 10.0}, {20.0, 21.0}});
  b.temperatures.push_back({"bed", "degC", {0.0}, {25.0}});
  const Session both = joined({a, b});
  ASSERT_EQ(both.observations.size(), a.observations.size() + b.observations.size());
  const Observation& later = both.observations[a.observations.size()];
  EXPECT_EQ(later.recording, 1);
  EXPECT_EQ(both.ownTime(later), b.observations[0].time);
  EXPECT_GT(later.time, both.observations[a.observations.size() - 1].time);
  EXPECT_EQ(both.rowText(3, 1), "line 3 of b.csv");
  EXPECT_EQ(both.rowText(3, 0), "row 3 of a.bag");
  EXPECT_THAT(both.placements, ElementsAre("a.bag", "b.bag")) << "set down anew: a place of its own";
  EXPECT_EQ(both.temperatures[0].value.size(), 3U);
  EXPECT_THAT(both.warning, HasSubstr("in the order given"));
  EXPECT_EQ(both.source, "a.bag:b.bag");
}

TEST(Joined, APlacementIsEachSessionsOwn) {
  test::TurnedPlate plate(3);
  const Session a = plate.session("a.bag", {0.0, 1.5707963}), b = plate.session("b.bag", {1.5707963, 0.0});
  EXPECT_THAT(joined({a, b}).placements, ElementsAre("a.bag: 0", "a.bag: 90", "b.bag: 90", "b.bag: 0"));
  Session c = plate.session("c.bag", {0.0}, 0, false), d = plate.session("d.bag", {0.0}, 0, false);
  c.artifact.poseKnown = d.artifact.poseKnown = true;
  EXPECT_TRUE(joined({c, d}).placements.empty()) << "where the file says, in both";
}

TEST(Joined, StandsInTheOrderOfItsDates) {
  test::TurnedPlate plate(4);
  Session a = plate.session("a.bag", {0.0}), b = plate.session("b.bag", {0.0});
  a.epoch = 1.7e9 + 86400;
  b.epoch = 1.7e9;
  const Session both = joined({a, b});
  EXPECT_EQ(both.recordings[0].source, "b.bag");
  EXPECT_EQ(both.recordings[1].begin, 86400.0);
  EXPECT_EQ(both.warning, "");
  b.epoch = a.epoch + 1.0;
  EXPECT_THAT(refusal(a, b), HasSubstr("before the end of a.bag"));
}

TEST(Joined, ADayWithoutATimeOfDayTellsNoOrderWithinIt) {
  test::TurnedPlate plate(4);
  constexpr double kDay = 86400.0;
  Session a = plate.session("a.bag", {0.0}), b = plate.session("b.bag", {0.0});
  a.epoch = b.epoch = 20000 * kDay;
  const Session both = joined({a, b});
  EXPECT_EQ(both.recordings[0].source, "a.bag");
  EXPECT_GT(both.recordings[1].begin, kDay);
  EXPECT_THAT(both.warning, HasSubstr("no time of day"));
  a.epoch = b.epoch + 36900.0;  // the other may have been measured before it or after it
  EXPECT_EQ(joined({a, b}).recordings[0].source, "a.bag");
  EXPECT_EQ(joined({b, a}).recordings[0].source, "b.bag");
  a.epoch = b.epoch;
  b.epoch = a.epoch + kDay;
  EXPECT_EQ(joined({a, b}).recordings[1].begin, kDay);
  EXPECT_EQ(joined({a, b}).warning, "");
}

TEST(Joined, RefusesWhatDoesNotBelongTogether) {
  test::TurnedPlate plate(5);
  const Session a = plate.session("a.bag", {0.0}), b = plate.session("b.bag", {0.0});
  EXPECT_THAT(refusal(a, a), HasSubstr("is the same session as a.bag"));
  Session other = b;
  other.machine = Machine::load("five_axis");
  EXPECT_THAT(refusal(a, other), HasSubstr("another machine"));
  other = b;
  other.artifact.name = "bar";
  EXPECT_THAT(refusal(a, other), HasSubstr("artifact 'bar', not 'plate'"));
  other = b;
  other.artifact.features[2].position[0] += 3e-6;
  EXPECT_THAT(refusal(a, other), HasSubstr("'b2' of artifact 'plate' is 3 um away from its position in"));
  other = b;
  other.artifact.tipRadius = 2e-3;
  EXPECT_THAT(refusal(a, other), HasSubstr("name the styli"));
  other = b;
  other.observations[0].laserReading = 0.01;
  EXPECT_THAT(refusal(a, other), HasSubstr("a laser, not by touch"));
  other = b;
  other.compensation.stated = ControllerCompensation::Stated::kNone;
  EXPECT_THAT(refusal(a, other), HasSubstr("another compensation"));
}

TEST(Joined, GoesOnFromWhatIsJoinedAlready) {
  test::TurnedPlate plate(7);
  const Session a = plate.session("a.bag", {0.0}), b = plate.session("b.bag", {0.0}, 0, false),
                c = plate.session("c.bag", {0.0});
  const Session all = joined({a, b, c}), later = joined({joined({a, b}), c});
  EXPECT_EQ(sessionHash(later), sessionHash(all));
  EXPECT_EQ(later.placements, all.placements);
  EXPECT_EQ(later.recordings.at(2).begin, all.recordings.at(2).begin);
  EXPECT_THAT(refusal(joined({a, b}), b), HasSubstr("b.bag: is the same session as b.bag"));
}

TEST(Joined, PlacementAndStylusAreNotTheSameToAHash) {
  test::TurnedPlate plate(8);
  plate.artifact.styli = {{"A", 1e-3, Eigen::Vector3d::Zero(), true},
                          {"B", 1e-3, Eigen::Vector3d::Zero(), true}};
  Session a = plate.session("a.bag", {0.0, 1.5707963});
  a.observations[0].placement = 1;
  Session b = a;
  b.observations[0].placement = 0;
  b.observations[0].stylus = 1;
  EXPECT_NE(sessionHash(a), sessionHash(b));
}

TEST(Joined, HasAHashOfItsOwn) {
  test::TurnedPlate plate(6);
  const Session a = plate.session("a.bag", {0.0}), b = plate.session("b.bag", {0.0});
  EXPECT_NE(sessionHash(joined({a, b})), sessionHash(joined({b, a})));
  EXPECT_EQ(sessionHash(joined({a, b})), sessionHash(joined({a, b})));
}

}  // namespace
}  // namespace mm
