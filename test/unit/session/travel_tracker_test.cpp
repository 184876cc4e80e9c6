#include "session/travel_tracker.h"

#include <gtest/gtest.h>

#include <cmath>

namespace mm {
namespace {

constexpr std::int64_t kCycle = 2000000;  // ns: 500 Hz

/// An hour of an encoder at rest that says a nanometre a second, up and down, in its last digit.
TEST(TravelTracker, anEncoderAtRestHasNoDirectionAndNoReversals) {
  TravelTracker tracker(travelDeadband(JointKind::kLinear));
  int changes = 0;
  for (int i = 0; i < 1800000; ++i)
    changes += tracker.take(i * kCycle, 0.005 + (i % 3 - 1) * 1e-9, i % 2 ? 1e-9 : -1e-9);
  EXPECT_EQ(changes, 0);
  EXPECT_EQ(tracker.direction(), 0.0);
  EXPECT_TRUE(std::isnan(tracker.sinceReversal()));
}

TEST(TravelTracker, aReversalCountsBeyondTheDeadbandFromTheFarthestReading) {
  TravelTracker tracker(1e-6);
  std::int64_t t = 0;
  const auto at = [&](double um) { return tracker.take(t += kCycle, um * 1e-6, 0.0); };
  EXPECT_FALSE(at(0.0));
  EXPECT_FALSE(at(0.9));
  EXPECT_TRUE(at(1.5));
  EXPECT_EQ(tracker.direction(), 1.0);
  EXPECT_FALSE(at(100.0));
  EXPECT_FALSE(at(99.1));
  EXPECT_FALSE(at(100.2)) << "farther than before";
  EXPECT_FALSE(at(99.3));
  EXPECT_TRUE(at(99.0));
  EXPECT_EQ(tracker.direction(), -1.0);
  EXPECT_NEAR(tracker.sinceReversal(), 1.2e-6, 1e-15);
  EXPECT_FALSE(at(90.2));
  EXPECT_NEAR(tracker.sinceReversal(), 10e-6, 1e-15);
}

TEST(TravelTracker, whereReadingsAreFarApartTheVelocityOfAJointThatMovesCounts) {
  TravelTracker tracker(1e-6);
  EXPECT_TRUE(tracker.take(1000000000, 0.0, 0.01));
  EXPECT_EQ(tracker.direction(), 1.0);
  EXPECT_EQ(tracker.sinceReversal(), 0.0) << "it was under way: so much at the least";
  EXPECT_TRUE(tracker.take(3000000000, 0.0, -0.01)) << "there and back in between";
  EXPECT_FALSE(tracker.take(5000000000, 0.0, 1e-9)) << "at rest";
  EXPECT_EQ(tracker.direction(), -1.0);
}

TEST(TravelTracker, whatIsNoNumberTellsNothing) {
  TravelTracker tracker(1e-6);
  tracker.take(kCycle, 0.0, 0.0);
  EXPECT_FALSE(tracker.take(2 * kCycle, NAN, 0.0));
  EXPECT_TRUE(tracker.take(3 * kCycle, 5e-6, 0.0));
  tracker.tell(2 * kCycle, -1.0);
  EXPECT_EQ(tracker.direction(), 1.0) << "who tells has not seen the reversal yet";
  tracker.tell(3 * kCycle, -1.0);
  EXPECT_EQ(tracker.direction(), -1.0);
  EXPECT_EQ(tracker.sinceReversal(), 0.0) << "so much at the least";
  tracker.take(4 * kCycle, 2e-6, 0.0);
  EXPECT_NEAR(tracker.sinceReversal(), 3e-6, 1e-15);
  tracker.forget();
  EXPECT_EQ(tracker.direction(), 0.0);
}

// before: each of these was a reversal
TEST(TravelTracker, anEncoderThatDithersByADigitAtRestHasNoDirection) {
  TravelTracker tracker(1e-6);
  EXPECT_FALSE(tracker.take(kCycle, 0.0, 10e-6)) << "a tenth of a micrometre in a hundredth of a second";
  EXPECT_EQ(tracker.direction(), 0.0);
  tracker.tell(kCycle, -1.0);
  for (std::int64_t i = 1; i < 20; ++i)  // four readings a second
    EXPECT_FALSE(tracker.take(i * 250000000, (i % 2) * 1e-7, i % 2 ? 2e-6 : -2e-6)) << i;
  EXPECT_EQ(tracker.direction(), -1.0);
  tracker.forget();
  tracker.tell(0, -1.0);
  EXPECT_FALSE(tracker.take(kCycle, 0.0, 10e-3)) << "what was told is of one who saw it move";
  EXPECT_EQ(tracker.direction(), -1.0);
}

TEST(TravelTracker, anotherZeroIsNoMotion) {
  TravelTracker tracker(1e-6);
  tracker.take(kCycle, 0.0, 0.0);
  tracker.take(2 * kCycle, 5e-3, 0.0);
  tracker.countAnew();
  EXPECT_FALSE(tracker.take(3 * kCycle, -0.3, 0.0));
  EXPECT_EQ(tracker.direction(), 1.0);
  EXPECT_NEAR(tracker.sinceReversal(), 5e-3, 1e-12);
  EXPECT_TRUE(tracker.take(4 * kCycle, -0.301, 0.0));
  EXPECT_NEAR(tracker.sinceReversal(), 1e-3, 1e-12);
}

TEST(TravelTracker, theWayBackWithinTheDeadbandIsTold) {
  TravelTracker tracker(1e-6);
  tracker.take(kCycle, 0.0, 0.0);
  tracker.take(2 * kCycle, 5e-3, 0.0);
  EXPECT_EQ(tracker.back(), 0.0);
  tracker.take(3 * kCycle, 5e-3 - 0.9e-6, 0.0);
  EXPECT_EQ(tracker.direction(), 1.0);
  EXPECT_NEAR(tracker.back(), 0.9e-6, 1e-12);
}

}  // namespace
}  // namespace mm
